"""What a hidden effect is to the twin: an edit of the MuJoCo model, or of what drives it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from servosight.sim.bench import Assembly

Array = NDArray[np.float64]
Values = Mapping[str, float]
Polyline = tuple[Array, Array]
"""Knots of a command, (time_s, command_deg); a time that stands twice is a jump."""


def _leave_model(assembly: Assembly, values: Values) -> None:
    """The effect does not touch the model."""


def _leave_command(command: Polyline, values: Values) -> Polyline:
    return command


@dataclass(frozen=True)
class HiddenEffect:
    """One physical effect, realised by MuJoCo's own means.

    ``id`` and the names in ``defaults`` are the catalogue's, and so are the units: torques in
    degrees of position error. ``edit`` changes the model before it is compiled. ``command`` maps
    the knots of the command before the amplifier sees it. ``regulate`` returns a function that is
    called before each step, where MuJoCo has no term of its own.
    """

    id: str
    defaults: Values
    edit: Callable[[Assembly, Values], None] = _leave_model
    command: Callable[[Polyline, Values], Polyline] = _leave_command
    regulate: Callable[[mujoco.MjModel, mujoco.MjData, Values], Callable[[], None]] | None = None
