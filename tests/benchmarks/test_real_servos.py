"""The benchmark on logs of real servos: it reads them, and scores as other tools do."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

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
