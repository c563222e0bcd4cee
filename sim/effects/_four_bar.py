"""Horn, pushrod and lever as bodies with hinges: a four-bar linkage closed by a constraint.

Unlike in ``linkage_geometry`` the rod is as short as it is drawn, so that it turns. Rod and lever
are light, and all inertia is the motor's: play before them (``backlash``) is that of a surface
which its own friction holds.
"""

from __future__ import annotations

import mujoco
import numpy as np

from servosight.sim.bench import HARD_IMPEDANCE, Assembly, link
from servosight.sim.effects._contract import EffectValues, HiddenEffect
from servosight.sim.linkage import CRANK_MM, SHAFT_MM, Linkage

_M = 1e-3  # a millimetre
_MASS_KG = 1e-8  # of the rod: its weight is far below the friction that holds a surface behind play


def linkage(values: EffectValues) -> Linkage:
    """Radius of the horn [mm], and its angle off square at zero, ``offset`` [deg]."""
    return Linkage(values["horn"], CRANK_MM, values["offset"])


def edit(assembly: Assembly, values: EffectValues) -> None:
    """Hinge a rod to what turns with the surface so far, and the surface's lever to the world."""
    spec = assembly.spec
    shape = linkage(values)
    shaft = np.array([*SHAFT_MM, 0.0])
    lower, upper = (np.array([*pin, 0.0]) for pin in shape.pins_mm(0.0, 0.0))
    driver = spec.joint(assembly.surface[-1]).parent
    lever = link(spec.worldbody, "lever")
    lever.pos = -_M * shaft  # the motor stands at the origin
    assembly.hinge(lever, "lever")
    rod = link(driver, "rod")
    rod.mass = _MASS_KG
    rod.pos = _M * (lower - shaft)
    assembly.hinge(rod, "rod")
    spec.add_equality(
        type=mujoco.mjtEq.mjEQ_CONNECT,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1="rod",
        name2="lever",
        data=[*(_M * (upper - lower)), *[0.0] * 9],
        solref=assembly.hard_reference,
        solimp=HARD_IMPEDANCE,
    )
    assembly.surface[:] = ["lever"]


EFFECT: HiddenEffect = HiddenEffect(
    "four_bar", {"horn": 16.0, "offset": 20.0}, edit=edit, linkage=linkage
)
