"""The twin under a command that comes row by row does what it does under one known before."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.models.core import InputError
from servosight.models.excitation import Excitation
from servosight.sim.bench import BenchParameters
from servosight.sim.live import LiveTwin
from servosight.sim.run import run

BENCH = BenchParameters.with_response(0.9, 0.02, 0.6, 1.5)


@pytest.mark.parametrize("effects", [{}, {"backlash": {"gap": 1.5}}, {"coulomb_friction": {}}])
def test_the_live_twin_agrees_with_the_one_that_knows_the_command(
    effects: dict[str, dict[str, float]],
) -> None:
    rows_s = np.array([0.0, 0.05, 0.2137, 0.4, 0.5])
    command = np.array([0.0, 12.0, -7.0, 5.0, 5.0])
    known = run(BENCH, effects, Excitation(rows_s, command))
    live = LiveTwin(BENCH, effects)
    for value, width in zip(command[:-1], np.diff(rows_s), strict=True):
        for _ in range(7):  # in pieces, as on a wire
            reported = live.step(float(value), float(width / 7))
    seen = live.between(0.0, 0.5)
    # The play comes to rest where its friction leaves it, which depends on how it began.
    error = seen.surface_deg[:-1] - known.surface_deg[: len(seen.surface_deg) - 1]
    assert np.abs(error).max() < (0.05 if effects else 1e-3)
    assert reported == pytest.approx((known.motor_deg[-1] - 1.5) / 0.9, abs=0.05)


def test_without_torque_it_stands_still_and_time_passes() -> None:
    live = LiveTwin(BENCH, {})
    live.step(10.0, 0.1)
    stood = live.step(None, 0.3)
    assert live.time_s == pytest.approx(0.4)
    assert np.ptp(live.between(0.11, 0.4).surface_deg) < 1e-9
    assert live.step(None, 0.1) == stood


def test_an_effect_on_the_command_itself_is_refused() -> None:
    with pytest.raises(InputError, match="dead_time"):
        LiveTwin(BENCH, {"dead_time": {"delay": 0.01}})
