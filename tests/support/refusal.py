"""Logs that cannot be imported."""

from __future__ import annotations

from pathlib import Path

import pytest

from servosight.models.core import InputError
from servosight.models.io.importers import Request, import_recording


def refused(path: Path, request: Request, *words: str) -> None:
    """The import says in one sentence the file, what it expected, and ``words``."""
    with pytest.raises(InputError) as caught:
        import_recording(path, request)
    sentence = str(caught.value)
    assert "\n" not in sentence
    for word in (path.name, "expected", *words):
        assert word in sentence, sentence
