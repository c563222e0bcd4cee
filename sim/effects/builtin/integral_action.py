"""A controller whose integral is added to its goal, as firmware does at each of its steps."""

from __future__ import annotations

import math

from servosight.sim.effects._contract import EffectValues, HiddenEffect, Regulator, Twin


def integral(twin: Twin, values: EffectValues, limit_deg: float) -> Regulator:
    """Add ``rate`` [1/s] times the integral of the error, less ``lag`` [s] times the speed, up to
    ``limit_deg``.

    The integral begins with the load that it has held before.
    """
    model, data = twin.model, twin.data
    degree = twin.bench.torque(1.0)
    most = math.radians(limit_deg)

    def limited(torque: float) -> float:
        return min(max(torque, -most), most)

    held = limited(math.radians(twin.load_torque() / degree))
    rising, since = 0.0, data.time

    def integrate() -> None:
        nonlocal held, rising, since
        held = limited(held + rising * (data.time - since))
        since = data.time
        error = float(data.ctrl[0]) - twin.angle
        rising = values["rate"] * (error - values["lag"] * twin.speed)
        data.ctrl[:] += limited(held + 0.5 * model.opt.timestep * rising)

    return integrate


def supply(twin: Twin, values: EffectValues) -> Regulator:
    """Without a limit."""
    return integral(twin, values, math.inf)


EFFECT: HiddenEffect = HiddenEffect("integral_action", {"rate": 8.0, "lag": 0.01}, supply=supply)
