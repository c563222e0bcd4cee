"""A firmware that gives no torque within its dead band, and all of it outside.

MuJoCo's actuators have no dead band, but their force can be limited: with c(e, a) for e clipped to
+-a, the drive e - 5 c(e, half_width) + 4 c(e, 1.25 half_width) is 0 within the band, e from 1.25
half widths on, and a line between. Two more amplifiers stand beside each one for that.
"""

from __future__ import annotations

from servosight.sim.bench import Assembly
from servosight.sim.effects._contract import EffectValues, HiddenEffect


def edit(assembly: Assembly, values: EffectValues) -> None:
    """Add both amplifiers to each, limited to five times ``half_width`` [deg]."""
    if values["half_width"] == 0.0:  # MuJoCo refuses an empty range
        return
    edge = 5.0 * assembly.bench.torque(values["half_width"])
    for one in list(assembly.amplifiers):
        low, high = one.forcerange
        assembly.amplifier(-5.0 * one.gainprm[0], max(-5.0 * high, -edge), min(-5.0 * low, edge))
        assembly.amplifier(4.0 * one.gainprm[0], max(4.0 * low, -edge), min(4.0 * high, edge))


EFFECT: HiddenEffect = HiddenEffect("dead_band", {"half_width": 1.0}, edit=edit)
