"""Play where a recording begins with the surface anywhere within it, as after an earlier motion."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.identify.fit import identify
from servosight.models.core import Recording
from servosight.models.effects import catalogue
from servosight.models.excitation import standard
from servosight.sim.bench import BenchParameters
from servosight.sim.live import LiveTwin

GAP_DEG, SIGMA_DEG, ROW_S = 2.7, 0.003, 0.02
SERVO = BenchParameters.with_response(1.0, 0.02, 0.6, 0.0)


@pytest.mark.parametrize("there_deg", [0.0, 5.0])
def test_the_gap_is_found_wherever_the_surface_rests(there_deg: float) -> None:
    """Truth: the MuJoCo twin, which has moved slowly to an angle and back before the recording.

    There the surface is left at a contact, 1.3 deg from the middle. The bound is three sigma, and
    a sigma of 0.3 % of the gap.
    """
    twin = LiveTwin(SERVO, {"backlash": {"gap": GAP_DEG}})
    ramp = np.concatenate([np.linspace(0.0, there_deg, 30), np.linspace(there_deg, 0.0, 30)])
    for angle in (*ramp, *np.zeros(20)):
        twin.step(float(angle), ROW_S)
    start_s = twin.time_s
    command = standard(4.0, 15.0, 2, 1.0 / ROW_S)
    for angle in command.command_deg[:-1]:
        twin.step(float(angle), ROW_S)
    time_s = np.arange(0.0, command.time_s[-1] - 0.01, 1.0 / 60.0)
    seen = twin.between(start_s, start_s + float(command.time_s[-1]))
    angle_deg = np.interp(start_s + time_s, seen.time_s, seen.surface_deg)
    noise = SIGMA_DEG * np.random.default_rng(1).standard_normal(time_s.size)
    recording = Recording("r", command.time_s, command.command_deg, time_s, angle_deg + noise)
    assert (abs(angle_deg[0]) > 1.2) == (there_deg > 0.0)

    fit = identify([recording], ["backlash"], catalogue=catalogue())

    gap = fit.parameters["backlash.gap"]
    assert gap.sigma is not None
    assert abs(gap.value - GAP_DEG) < 3.0 * gap.sigma
    assert gap.sigma < 0.003 * GAP_DEG
    assert fit.rmse_deg < 1.3 * SIGMA_DEG
