"""The steps of a fit of one picture, compiled: a model's own loop samples it, and calls ``step``.

One call gives up the interpreter's lock once. By a dozen short calls, each of which takes it back,
two threads took 1.6 times as long as one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit

from servosight.models.core import Array, Single
from servosight.tracking.core import inverted
from servosight.tracking.fit._kernels import equations
from servosight.tracking.fit._polar import Pixels

_LEAST_PIXELS = 60
_ITERATIONS = 12
_CLEAR = 0.98  # of the pixels within the gate: nothing covers them
_FARTHEST_RAD = 0.35  # from the start, within which a fit converges
_SHRINK = 0.03  # of a step near the answer, the next one
_LEAST_TURN_RAD = 1e-7

NO_DIRECTIONS: Single = np.empty((2, 0), np.float32)
"""In place of ``Pixels.outwards`` where the pivot is known."""

_kernel = njit(cache=True, nogil=True, error_model="numpy")


@dataclass(frozen=True)
class Rounds:
    """A model's compiled loop, and what it takes of the model and of a picture's ``pixels``.

    ``loop(*model, picture, state, aims, light)`` samples the model at the angle in ``state`` and
    calls ``step`` until that does not go on. Of the last sample it returns the pixels' places in
    the table, value and slopes there (3, pixels) and the number of pixels left out; then what
    ``step`` found.
    """

    loop: Callable[..., Any]
    model: tuple[Any, ...]
    pixels: Pixels


ANGLE, _START, _LAST, _COUNT, _FAILED = range(5)
"""Places in a fit's state: its angle, that of the start, the size of the last step [rad], how many
were made, and whether it failed."""


def state_at(angle_rad: float) -> Array:
    """The state in which a fit from an angle starts."""
    return np.array([angle_rad, angle_rad, np.inf, 0.0, 0.0])


def failed(state: Array) -> bool:
    """Whether a fit that ended in this state has no angle."""
    return bool(state[_FAILED])


@njit(cache=True, nogil=True, error_model="numpy", fastmath=True)
def _motion_rows(chosen, out, radius, outwards):  # type: ignore[no-untyped-def]
    """Change of each pixel with the surface's angle and, where ``outwards`` holds the pixels'
    directions, with its shift along x and along y; (1 or 3, pixels)."""
    shifted = outwards.shape[1] > 0
    rows = np.empty((3 if shifted else 1, chosen.size), np.float32)
    for i in range(chosen.size):
        rows[0, i] = out[1, i]
        if shifted:
            here = chosen[i]
            cos, sin = outwards[0, here], outwards[1, here]
            along = -out[1, i] / radius[here]
            rows[1, i] = along * sin - out[2, i] * cos
            rows[2, i] = along * cos + out[2, i] * sin
    return rows


@_kernel
def _solved(matrix, right, power, used):  # type: ignore[no-untyped-def]
    """Inverse of the normal matrix, solution, and the noise that it leaves of a pixel of weight 1;
    an empty inverse where too few pixels pass the gate, or they do not determine the unknowns."""
    inverse, solution = np.empty_like(matrix), np.zeros_like(right)
    if used < _LEAST_PIXELS or not inverted(matrix, inverse):
        return np.empty((0, 0)), solution, 0.0
    taken = 0.0
    for a in range(right.size):
        for b in range(right.size):
            solution[a] += inverse[a, b] * right[b]
        taken += right[a] * solution[a]
    return inverse, solution, np.sqrt(max(power - taken, 0.0) / used)


@_kernel
def _moved(state, aims, turn, sigma, clear):  # type: ignore[no-untyped-def]
    """Bring ``state`` up to date with a step by ``turn``, of an angle with this ``sigma``; whether
    another step is to follow."""
    before, first = state[_LAST], state[_COUNT] == 1.0
    state[ANGLE] += turn
    state[_LAST] = max(abs(turn), 1e-12)
    if abs(state[ANGLE] - state[_START]) > _FARTHEST_RAD:
        state[_FAILED] = 1.0
        return False
    # Steps shrink by about the same factor: stop where the next one is negligible.
    shrink = _SHRINK if first else min(abs(turn) / before, 1.0)
    exact = abs(turn) * shrink < max(aims[1] * sigma, _LEAST_TURN_RAD)
    # The first step is biased where something covers a part.
    enough = state[_COUNT] >= aims[0] and (clear or not first)
    return state[_COUNT] < _ITERATIONS and not (enough and exact)


@_kernel
def step(picture, index, radius, outwards, chosen, out, state, aims, light):  # type: ignore[no-untyped-def]
    """One weighted least-squares step for gain, offset and motion; ``state`` is brought up to date.

    ``picture`` is flattened; ``index`` and ``radius`` (pixels,) and ``outwards`` are those of the
    table, ``chosen`` places in it, ``out`` (3, chosen) value and slopes there. ``aims`` are the
    number of steps at least, the share of sigma to which the angle is to be exact, and 1 where the
    light is not known at first; ``light`` as in ``equations``. Returns whether another step is to
    follow; and grey levels, rows and weights of the pixels, the normal matrix, what ``_solved``
    makes of it, and the numbers of pixels within the gate and neither black nor white.
    """
    state[_COUNT] += 1.0
    motion = _motion_rows(chosen, out, radius, outwards)
    darker = state[_COUNT] == 1.0 and aims[2] > 0.0
    seen, rows, weight, used, inside, matrix, right, power = equations(
        picture, index, chosen, out[0], motion, light, darker
    )
    inverse, solution, noise = _solved(matrix, right, power, used)
    goes_on = inverse.size > 0
    if goes_on:
        # The slopes were those of the assumed gain.
        slopes = min(max(light[0] / max(solution[0], 1e-3), 0.5), 2.0)
        light[0], light[1] = solution[0], solution[1]
        sigma = np.sqrt(inverse[2, 2]) * noise
        goes_on = _moved(state, aims, slopes * solution[2], sigma, used > _CLEAR * inside)
    else:
        state[_FAILED] = 1.0
    return goes_on, (seen, rows, weight, matrix, inverse, solution, noise, used, inside)
