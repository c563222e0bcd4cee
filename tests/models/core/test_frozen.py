"""Values stay as they were made."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest

from servosight.identify.uncertainty import Matrix
from servosight.models.core import Actuator, Estimate, Recording, Signals

TIME_S = np.arange(0.0, 1.0, 0.01)
RECORDING = Recording(
    "run",
    TIME_S,
    np.sin(TIME_S),
    TIME_S,
    np.sin(TIME_S),
    details={"servo": "MG90S"},
    signals=Signals(TIME_S, {"current_A": np.cos(TIME_S)}),
)
MODEL = Actuator({"k": Estimate(1.0, 0.1, "-")}, (), {"method": "gradient"})


@pytest.mark.parametrize("name", ["command_time_s", "command_deg", "time_s", "angle_deg"])
def test_the_numbers_of_a_recording_stay(name: str) -> None:
    with pytest.raises(ValueError, match="read-only"):
        getattr(RECORDING, name)[0] = 1.0


@pytest.mark.parametrize(
    "mapping",
    [RECORDING.details, RECORDING.signals.values, MODEL.parameters, MODEL.provenance],  # type: ignore[union-attr]
)
def test_the_entries_of_a_mapping_stay(mapping: object) -> None:
    with pytest.raises(TypeError, match="item assignment"):
        mapping["k"] = 1.0  # type: ignore[index]


def test_what_it_was_made_from_may_change() -> None:
    given = {"k": Estimate(1.0, None, "-")}
    model = Actuator(given)
    given["k"] = Estimate(2.0, None, "-")
    assert model.value("k") == 1.0


def test_a_changed_copy_shares_the_rest() -> None:
    assert replace(RECORDING, name="again").angle_deg is RECORDING.angle_deg
    assert replace(RECORDING) == RECORDING


def test_a_value_is_copied_and_pickled() -> None:
    assert copy.deepcopy(MODEL) == MODEL
    assert pickle.loads(pickle.dumps(MODEL)) == MODEL
    assert MODEL.parameters == {"k": Estimate(1.0, 0.1, "-")}


def test_a_matrix_is_an_array_and_a_table() -> None:
    found = Matrix(("k", "T"), np.array([[4.0, 1.0], [1.0, np.nan]]))
    np.testing.assert_array_equal(np.asarray(found), found.values)
    assert np.asarray(found, dtype=np.float32).dtype == np.float32
    with pytest.raises(ValueError, match="copy"):
        np.array(found, dtype=np.float32, copy=False)
    assert "<th>T</th>" in found._repr_html_()
    with pytest.raises(ValueError, match="read-only"):
        found.values[0, 0] = 1.0
