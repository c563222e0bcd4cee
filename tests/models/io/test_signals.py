"""What else a log holds: kept beside the angle, and said where no model uses it."""

from __future__ import annotations

import math
import shlex
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from servosight.identify.problem import unused_disturbances
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
        (note,) = unused_disturbances([one])
        assert "a known disturbance (up to 2.00 N) is recorded and not used" in note
    still = import_recording(log(tmp_path / "b.csv", force=0.0), request)
    assert unused_disturbances([still]) == []


def renamed(path: Path, name: str) -> Path:
    """The log with another name for the column of the force, and no voltage's unit."""
    path.write_text(path.read_text().replace("force,volts [V]", name))
    return path


@pytest.mark.parametrize("name", ["disturbance_N,supply_V", "disturbance [N],supply_V"])
def test_a_column_that_is_called_a_disturbance_is_one(tmp_path: Path, name: str) -> None:
    """Imported without a map, and in a CSV file that is a recording by itself."""
    path = renamed(log(tmp_path / "a.csv"), name)
    for one in (import_recording(path, Request()), load_recording(path)):
        assert one.signals is not None
        assert list(one.signals.values) == ["disturbance_N", "supply_V"]
        assert one.disturbance_unit == "N"
        assert one.disturbance_at(one.time_s).max() == 2.0


def test_a_signal_with_gaps_that_nobody_asked_for_is_left_out(tmp_path: Path) -> None:
    path = renamed(log(tmp_path / "a.csv"), "force (N),supply_V")
    lines = path.read_text().splitlines()
    lines[9] = lines[9].rpartition(",")[0] + ","
    path.write_text("\n".join(lines))
    recording = import_recording(path, Request(parse_map(["disturbance=force"])))
    assert recording.signals is not None
    assert list(recording.signals.values) == ["disturbance_N"]
    assert "column supply_V is not kept" in recording.notes[0]
    with pytest.raises(InputError, match="row 10: column supply_V is nan"):
        import_recording(path, Request(parse_map(["disturbance=force", "supply=supply_V"])))


def test_a_column_that_may_be_a_disturbance_is_pointed_out(tmp_path: Path) -> None:
    path = renamed(log(tmp_path / "a.csv"), "ext_force_N,load")
    for one in (import_recording(path, Request()), load_recording(path)):
        (note,) = one.notes
        assert "column ext_force_N is not used" in note
        assert "--map disturbance=ext_force_N on the command line" in note
    request = Request(parse_map(["disturbance=ext_force_N"]))
    recording = import_recording(path, request)
    assert recording.notes == ()
    assert recording.disturbance_unit == "N"


@pytest.mark.parametrize(
    ("name", "advice"),
    [
        ("load_torque_Nm", "disturbance=load_torque_Nm"),
        ("F_ext", "disturbance=F_ext:UNIT"),
        ("external_force (N)", "'disturbance=external_force (N)'"),
        ("torque_ext [mNm]", "'disturbance=torque_ext [mNm]'"),
        ("tau_load", "disturbance=tau_load:UNIT"),
        ("loadTorque", "disturbance=loadTorque:UNIT"),
    ],
)
def test_names_of_a_load_are_pointed_out_with_a_map_to_copy(
    tmp_path: Path, name: str, advice: str
) -> None:
    """The map is quoted for a shell, and asks for no unit that the name has."""
    path = renamed(log(tmp_path / "a.csv"), f"{name},supply_V")
    (note,) = import_recording(path, Request()).notes
    assert f"column {name} is not used" in note
    assert f"--map {advice} on the command line" in note
    words = shlex.split(advice.replace("UNIT", "Nm"))
    assert import_recording(path, Request(parse_map(words))).notes == ()


@pytest.mark.parametrize("name", ["effort", "torque", "motor_torque_Nm", "tau", "load", "f_cut"])
def test_what_is_the_motors_own_is_not_pointed_out(tmp_path: Path, name: str) -> None:
    path = renamed(log(tmp_path / "a.csv"), f"{name},supply_V")
    assert import_recording(path, Request()).notes == ()


def test_a_force_in_a_mat_file_is_pointed_out(tmp_path: Path) -> None:
    t = 0.01 * np.arange(200)
    content = {"t": t, "u": np.sin(9 * t), "y": np.sin(9 * t), "force_N": 2.0 * (t > 1)}
    scipy.io.savemat(tmp_path / "a.mat", content)
    request = Request(parse_map(["command=u:rad", "angle=y:rad"]))
    (note,) = import_recording(tmp_path / "a.mat", request).notes
    assert "column force_N is not used" in note


@pytest.mark.parametrize(("on", "off"), [("1", "0"), ("1.000", "0.000"), ("on", "off")])
def test_a_csv_file_without_torque_at_the_end_is_cut(tmp_path: Path, on: str, off: str) -> None:
    """As a recording by itself, and imported; ``torque_enable`` is no signal."""
    rows = [f"{0.01 * i:.2f},{i % 7},{i % 5},{on if i < 70 else off}" for i in range(100)]
    path = tmp_path / "a.csv"
    path.write_text("\n".join(["time_s,command_deg,angle_deg,torque_enable", *rows]))
    for one in (load_recording(path), import_recording(path, Request())):
        assert one.time_s.size == 70
        assert "false in 30 of 100 rows" in one.notes[0]
        assert one.signals is None


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
    assert "up to 20.0 N" in unused_disturbances([recording])[0]
