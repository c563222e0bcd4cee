"""A bridge whose two halves do not match: an amplifier for each direction."""

from __future__ import annotations

from servosight.sim.bench import STRONG_NM, Assembly
from servosight.sim.effects._contract import EffectValues, HiddenEffect


def edit(assembly: Assembly, values: EffectValues) -> None:
    """Let the amplifier push only, and add one that pulls, ``ratio`` [-] times as strong."""
    (push,) = assembly.amplifiers
    push.forcerange = [0.0, STRONG_NM]
    assembly.amplifier(values["ratio"] * assembly.bench.loop_stiffness_nm_rad, high_nm=0.0)


EFFECT: HiddenEffect = HiddenEffect("asymmetric_gain", {"ratio": 0.8}, edit=edit)
