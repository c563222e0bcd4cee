"""JSON as it is written."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np

from servosight.models.base import json_text


def test_json_knows_numpy_and_never_nan() -> None:
    value = {
        "b": np.float64(1.5),
        "a": np.array([1.0, np.nan, np.inf]),
        "n": (np.int64(3), np.bool_(True), -math.inf, None),
        "p": Path("x"),
    }
    text = json_text(value)
    assert "NaN" not in text
    assert "Infinity" not in text
    assert list(json.loads(text)) == ["b", "a", "n", "p"]
    assert json.loads(text) == {
        "b": 1.5,
        "a": [1.0, None, None],
        "n": [3, True, None, None],
        "p": "x",
    }
