"""What belongs to a recording and not to the model: the angle's zero, the motion at its start."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import numpy as np

from servosight.identify.problem import own_start
from servosight.models.core import Array, InputError, Recording, either
from servosight.models.fmu import FmuRun, FmuVariable


class Model(Protocol):
    """An FMU, or one with effects around it."""

    @property
    def own(self) -> tuple[FmuVariable, ...]:
        """What belongs to a recording."""

    @property
    def parameters(self) -> tuple[FmuVariable, ...]:
        """What may be fitted besides."""

    def predict(self, run: FmuRun, names: Sequence[str], rows: Array) -> tuple[Array, list[str]]:
        """Angles [deg], (runs, samples), and errors."""


SCALES = {"bias": 1.0, "initial_angle": 1.0, "initial_speed": 10.0}
"""Sizes of a change that matters [deg], [deg/s]."""


def trusted(path: Path, trust: bool) -> None:
    """Raise InputError unless the user has said that the FMU's native code may run."""
    if not trust:
        raise InputError(
            f"{path}: an FMU runs native code with your rights, expected "
            f"{either('trust=True', '--trust')}; give it once you trust where the file is from"
        )


def first_guess(recording: Recording, model: Model) -> Array:
    """First guess of the recording's own numbers, in the order of ``model.own``."""
    gain = next((one.start for one in model.parameters if one.name == "k"), None)
    guesses = own_start(recording, 1.0 if gain is None else gain)
    guess = dict(zip(SCALES, guesses, strict=True))
    return np.array([guess[one.name] for one in model.own])


def predicted(
    model: Model, run: FmuRun, names: Sequence[str], rows: Array
) -> tuple[Array, list[str]]:
    """Angles [deg], (runs, samples); without a bias of its own, the zero of the angle is fitted."""
    angles, errors = model.predict(run, names, rows)
    if not any(one.name == "bias" for one in model.own):
        angles = angles + (run.recording.angle_deg - angles).mean(axis=1, keepdims=True)
    return angles, errors


def bounds_of(variables: Sequence[FmuVariable]) -> tuple[Array, Array, Array]:
    """Low, high and the size of a change that matters, (variables,) each."""
    low = np.array([one.low for one in variables])
    high = np.array([one.high for one in variables])
    scale = np.array([SCALES.get(one.name) or _size(one) for one in variables])
    return low, high, scale


def _size(one: FmuVariable) -> float:
    """A tenth of the start value; where that is zero, of the range or 1."""
    if one.start:
        return 0.1 * abs(one.start)
    return 0.01 * (one.high - one.low) if np.isfinite(one.high - one.low) else 0.1
