"""An amplifier that gives no torque for small position errors.

MuJoCo's actuators have no dead band, but their force can be limited: beside each amplifier a second
one that works the other way with the same stiffness and a force limited to the band's edge leaves
``e - clip(e, -half_width, half_width)``, at every stage of the integrator.
"""

from __future__ import annotations

from servosight.sim.bench import Assembly
from servosight.sim.effects._contract import EffectValues, HiddenEffect


def edit(assembly: Assembly, values: EffectValues) -> None:
    """Add the counter-amplifiers, limited to ``half_width`` [deg]."""
    if values["half_width"] == 0.0:  # MuJoCo refuses an empty range
        return
    edge = assembly.bench.torque(values["half_width"])
    for one in list(assembly.amplifiers):
        low, high = one.forcerange
        assembly.amplifier(-one.gainprm[0], max(-high, -edge), min(-low, edge))


EFFECT: HiddenEffect = HiddenEffect("dead_zone", {"half_width": 1.0}, edit=edit)
