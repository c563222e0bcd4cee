"""What else a log holds: kept beside the angle, and said where no model uses it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from servosight.identify.problem import usable_views
from servosight.models.core import InputError
from servosight.models.io import load_recording, save_recording
from servosight.models.io.importers import Request, import_recording, parse_map

HEADER = "time_s,command_deg,angle_deg,force,volts [V]"


def log(path: Path, force: float = 2.0) -> Path:
    rows = [
        f"{0.01 * i:.2f},{math.sin(0.2 * i)},{math.sin(0.2 * i - 0.3)},"
        f"{force * (i > 30)},{12 - 0.01 * i}"
        for i in range(60)
    ]
    path.write_text("\n".join([HEADER, *rows]))
    return path


def test_signals_are_kept_with_their_units(tmp_path: Path) -> None:
    request = Request(parse_map(["disturbance=force:N", "supply=volts"]))
    recording = import_recording(log(tmp_path / "a.csv"), request)
    assert recording.signals is not None
    assert list(recording.signals.values) == ["disturbance_N", "supply_V"]
    save_recording(recording, tmp_path / "rec")
    again = load_recording(tmp_path / "rec")
    assert again.signals is not None
    np.testing.assert_array_equal(again.signals.time_s, recording.time_s)
    for name, values in recording.signals.values.items():
        np.testing.assert_array_equal(again.signals.values[name], values)


def test_a_disturbance_is_never_ignored_in_silence(tmp_path: Path) -> None:
    """It is among the warnings of every fit, also when read back; a constant zero is not."""
    request = Request(parse_map(["disturbance=force:N"]))
    recording = import_recording(log(tmp_path / "a.csv"), request)
    save_recording(recording, tmp_path / "rec")
    for one in (recording, load_recording(tmp_path / "rec")):
        (note,) = usable_views([one])[1]
        assert "force is a known disturbance" in note
        assert "not used as an input" in note
    assert import_recording(log(tmp_path / "b.csv", force=0.0), request).notes == ()


def test_a_signal_without_unit_is_asked_for(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"force for the disturbance has no unit.*=force:N"):
        import_recording(log(tmp_path / "a.csv"), Request(parse_map(["disturbance=force"])))


def test_the_pulses_of_emps(tmp_path: Path) -> None:
    t = 0.001 * np.arange(200)[:, None]
    pulses = 20.0 * (t > 0.1)
    path = tmp_path / "a.mat"
    scipy.io.savemat(path, {"t": t, "qg": np.sin(9 * t), "qm": np.sin(9 * t), "pulses_N": pulses})
    recording = import_recording(path, Request())
    assert recording.signals is not None
    np.testing.assert_array_equal(recording.signals.values["disturbance_N"], pulses[:, 0])
    assert "pulses_N is a known disturbance" in recording.notes[0]
