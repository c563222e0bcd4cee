"""The benchmark on logs of real servos: it reads them, and scores as other tools do."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat
from scipy.signal import chirp, cont2discrete, lfilter

from real_servos.emps import Controller
from real_servos.logs import RunResult, error_mrad, log
from real_servos.pairs import agree, page


def test_a_log_is_read_and_scored(real_data: Path) -> None:
    recording = log("xl330", "sin_sin", 400)
    assert recording.time_s.size > 1000
    assert error_mrad(recording, recording.angle_deg) == 0.0
    shifted = replace(recording, angle_deg=recording.angle_deg + 1.0)
    assert error_mrad(shifted, recording.angle_deg) == pytest.approx(17.45, abs=0.01)


NAMES = ("coulomb_friction", "backlash")


def one_run(
    *named: str,
    equivalents: tuple[tuple[str, ...], ...] = (),
    one_of: dict[str, tuple[str, ...]] | None = None,
    T: float,
) -> RunResult:
    return {
        "named": named,
        "equivalents": equivalents,
        "one_of": one_of or {},
        "stability": dict.fromkeys(named, 0.8),
        "over_floor": 1.5,
        "parameters": {"T": [T, 0.003], **{f"{name}.size": [0.5, None] for name in named}},
        "shown_from": {name: (f"{name}.size", 0.2, False) for name in NAMES},
    }


def test_two_runs_are_compared_by_names_and_by_what_they_allow() -> None:
    results = {
        "s-32-slow": one_run("coulomb_friction", T=0.020),
        "s-32-fast": one_run(
            equivalents=(("coulomb_friction",),),
            one_of={"backlash": ("coulomb_friction",)},
            T=0.026,
        ),
        "x-1-slow": one_run("coulomb_friction", T=0.02),
    }
    text = page(results, ["s-32", "x-1"], ("slow", "fast"))
    assert "| s-32 | `fast` | nothing | backlash or coulomb_friction | 1.5 |" in text
    assert "| s-32 | no | yes | yes | none | 1.4 sigma |" in text
    assert "| x-1 | `slow` |" in text
    assert "| x-1 | no" not in text  # one run is no pair


@pytest.mark.parametrize(
    ("limit", "same"),
    [((0.2, False), False), ((0.8, False), True), ((0.8, True), False), ((None, False), True)],
    ids=["shows", "too small", "below a limit", "shows no size"],
)
def test_what_a_run_could_not_have_shown_is_not_counted_against_the_other(
    limit: tuple[float | None, bool], same: bool
) -> None:
    first = one_run("coulomb_friction", "backlash", T=0.02)
    second = one_run("coulomb_friction", T=0.02)
    second["shown_from"]["backlash"] = ("backlash.size", *limit)
    assert agree(first, second) is same
    assert agree(second, first) is same


def test_what_a_run_leaves_open_is_not_counted_against_the_other() -> None:
    first = one_run("coulomb_friction", "backlash", T=0.02)
    assert not agree(first, one_run("coulomb_friction", T=0.02))
    left_open = one_run("coulomb_friction", one_of={"dead_zone": ("backlash",)}, T=0.02)
    assert agree(first, left_open)
    assert agree(left_open, first)


def test_the_delays_of_emps_controller_are_counted(tmp_path: Path) -> None:
    """A discrete loop of a known mass: the continuous one that answers like it has the mass and
    the friction that ``late`` takes off. What is left is of the next order in the delay,
    which at 6 Hz is up to 1.5 ms or 0.057 rad: some 20th."""
    mass, viscous, gtau, kv, kp, step_s = 95.0, 200.0, 35.0, 240.0, 160.0, 1e-3
    time_s = step_s * np.arange(6000)
    reference = 0.1 * chirp(time_s, 0.2, 6.0, 8.0, phi=-90.0)
    a, b = np.array([[0.0, 1.0], [0.0, -viscous / mass]]), np.array([[0.0], [gtau / mass]])
    plant = cont2discrete((a, b, np.eye(2), np.zeros((2, 1))), step_s)
    state, position, volts = np.zeros(2), np.zeros(6000), np.zeros(6000)
    for n in range(6000):
        position[n] = state[0]
        speed = (position[n] - position[max(n - 2, 0)]) / (2.0 * step_s)
        volts[n] = kv * (kp * (reference[n] - position[n]) - speed)
        state = plant[0] @ state + plant[1][:, 0] * volts[n]
    recorded = {"t": time_s, "qg": reference, "qm": position, "vir": volts}
    savemat(tmp_path / "emps.mat", {**recorded, "gtau": gtau, "kv": kv, "kp": kp})
    controller = Controller.of(tmp_path / "emps.mat")
    assert controller.samples == 2
    apart = []
    for late in ({"M [kg]": 0.0, "Fv [N s/m]": 0.0}, controller.late):
        damping = viscous - late["Fv [N s/m]"] + gtau * kv
        loop = [mass - late["M [kg]"], damping, controller.stiffness]
        held = cont2discrete(([controller.stiffness], loop), step_s)
        apart.append(np.std(position - lfilter(held[0].ravel(), held[1], reference)))
    assert apart[1] < apart[0] / 20.0
