"""The bench with its hidden effects, assembled, and the longest step that these allow."""

from __future__ import annotations

from collections.abc import Iterable

from servosight.sim.bench import LONGEST_STEP_S, STEPS_PER_T, Assembly, BenchParameters, assemble
from servosight.sim.effects import HiddenEffect, Twin
from servosight.sim.stepping import ActiveEffects


def longest_step_s(
    T: float, effects: Iterable[HiddenEffect], steps_per_T: int = STEPS_PER_T
) -> float:
    """The step of a servo with time constant ``T`` [s]: T over the most steps that are asked for.

    ``steps_per_T`` is asked for by the purpose of the simulation, more by some of the effects.
    """
    return min(LONGEST_STEP_S, T / max([steps_per_T, *(one.steps_per_T for one in effects)]))


def with_effects(bench: BenchParameters, chosen: ActiveEffects, step_s: float) -> Assembly:
    """The bench's model with the ``chosen`` effects in it, to be compiled."""
    assembly = assemble(bench, step_s)
    for effect, values in chosen:
        effect.edit(assembly, values)
    return assembly


def put_to_rest(twin: Twin, assembly: Assembly, angle_rad: float) -> list[int]:
    """Turn motor, sensor and surface to an angle; the surface's places in ``qpos``."""
    surface = [int(twin.model.joint(name).qposadr[0]) for name in assembly.surface]
    for hinge in {twin.motor, twin.sensor, surface[0]}:
        twin.data.qpos[hinge] = angle_rad
    return surface
