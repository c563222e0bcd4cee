"""Limit cycles of a loop around a servo, predicted by harmonic balance."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from servosight.models.core import Actuator, Array
from servosight.models.effects import Effect
from servosight.models.plant._describing import describing_function
from servosight.models.plant._metrics import natural_frequency_hz

AMPLITUDES_DEG = (0.05, 40.0)
"""Amplitudes of the command that are searched."""
FREQUENCIES = (0.02, 2.0)
"""Frequencies that are searched, as shares of the servo's natural frequency."""
GRID = (14, 22)
"""Amplitudes and frequencies of the search."""
NEAR_RAD = 1.5
"""Corners of a cell that holds a solution are within this phase of it."""
SMALLEST_GAIN = 1e-9
"""Stands for none at all, such as that of a sine within a play."""
LOST = 1e-3
"""Below this share of the static gain, a sine of the command is lost."""
FIRST_STEP = 0.02
"""The first amplitude searched is by this share larger than one that is lost."""
BISECTIONS = 12
STEP = 1e-3
"""Relative step of derivatives."""


@dataclass(frozen=True)
class LimitCycle:
    """A self-sustained oscillation.

    ``command_deg`` and ``angle_deg`` are the amplitudes of the command's and the angle's first
    harmonic. It is ``stable`` where a disturbed oscillation returns to it; one that is not is the
    border between oscillations that die out and those that grow.
    """

    frequency_hz: float
    command_deg: float
    angle_deg: float
    stable: bool


def limit_cycles(
    actuator: Actuator,
    loop: Callable[[complex], complex],
    catalogue: Mapping[str, Effect],
    *,
    amplitudes_deg: tuple[float, float] | None = None,
    frequencies_hz: tuple[float, float] | None = None,
) -> tuple[LimitCycle, ...]:
    """Oscillations of the servo in a loop, the slowest first.

    ``loop`` gives the rest of the loop at s [rad/s], from the servo's angle to minus its command:
    a ``control.TransferFunction`` of controller times vehicle. Oscillations are where loop times
    describing function is -1, searched for commands of ``amplitudes_deg`` (default 0.05 to 40) at
    ``frequencies_hz`` (default 0.02 to 2 times the servo's natural frequency). Stable by Loeb's
    criterion (Gelb and Vander Velde, 1968, section 3.3). Harmonic balance holds where the loop
    damps the third harmonic; confirm what it predicts by simulation.
    """
    natural = natural_frequency_hz(actuator.value("T"))
    low, high = frequencies_hz or (FREQUENCIES[0] * natural, FREQUENCIES[1] * natural)
    smallest, largest = amplitudes_deg or AMPLITUDES_DEG
    lost = _lost_deg(actuator, low, (smallest, largest), catalogue)
    least = smallest if lost == 0.0 else FIRST_STEP * lost
    excess = np.log(np.geomspace(least, largest - lost, GRID[0]))
    rates = np.log(np.geomspace(low, high, GRID[1]))

    def balance(x: Array) -> Array:
        """Logarithm of gain, and phase [rad], of the loop over -1.

        ``x`` are the logarithms of the command's amplitude beyond ``lost``, and of the frequency.
        """
        size, rate = lost + math.exp(x[0]), math.exp(x[1])
        there = describing_function(actuator, size, rate, catalogue)
        whole = -complex(loop(2j * math.pi * rate)) * there
        return np.array([math.log(max(abs(whole), SMALLEST_GAIN)), np.angle(whole)])

    grid = np.array([[balance(np.array([size, rate])) for rate in rates] for size in excess])
    found: list[LimitCycle] = []
    for i, j in np.argwhere(_holds_solution(grid)):
        start = np.array([excess[i : i + 2].mean(), rates[j : j + 2].mean()])
        reach = 2.0 * np.array([np.ptp(excess[:2]), np.ptp(rates[:2])])
        solution = _refined(balance, start, reach)
        if solution is None:
            continue
        size, rate = lost + math.exp(solution[0]), math.exp(solution[1])
        if any(
            math.isclose(rate, one.frequency_hz, rel_tol=1e-2)
            and math.isclose(size, one.command_deg, rel_tol=1e-2)
            for one in found
        ):
            continue
        gain = abs(describing_function(actuator, size, rate, catalogue))
        found.append(LimitCycle(rate, size, gain * size, _stable(balance, solution)))
    return tuple(sorted(found, key=lambda one: one.frequency_hz))


def _lost_deg(
    actuator: Actuator,
    frequency_hz: float,
    within: tuple[float, float],
    catalogue: Mapping[str, Effect],
) -> float:
    """Largest amplitude [deg] of a slow command that is lost in a play or in friction, 0 for none.

    Near it the describing function changes fastest: the search is finest there.
    """

    def moves(amplitude_deg: float) -> bool:
        gain = abs(describing_function(actuator, amplitude_deg, frequency_hz, catalogue))
        return gain > LOST * abs(actuator.value("k"))

    low, high = within
    if moves(low) or not moves(high):
        return 0.0
    for _ in range(BISECTIONS):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if moves(middle) else (middle, high)
    return high


def _holds_solution(grid: Array) -> Array:
    """Cells (amplitudes - 1, frequencies - 1) at whose corners gain and phase change sign."""
    corners = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[:-1, 1:], grid[1:, 1:]])
    low, high = corners.min(axis=0), corners.max(axis=0)
    near = np.all(np.abs(corners[..., 1]) < NEAR_RAD, axis=0)
    return np.asarray(np.all((low <= 0.0) & (high >= 0.0), axis=-1) & near)


def _refined(balance: Callable[[Array], Array], start: Array, reach: Array) -> Array | None:
    """The solution near ``start``; None where there is none within ``reach``."""
    from scipy.optimize import least_squares

    found = least_squares(
        balance, start, bounds=(start - reach, start + reach), diff_step=STEP, x_scale=reach
    )
    return found.x if np.max(np.abs(found.fun)) < STEP else None


def _stable(balance: Callable[[Array], Array], x: Array) -> bool:
    """Loeb's criterion: U_A V_w - V_A U_w > 0, of the balance U + jV."""
    step_a, step_w = STEP * np.eye(2)
    by_a = balance(x + step_a) - balance(x - step_a)
    by_w = balance(x + step_w) - balance(x - step_w)
    return bool(by_a[0] * by_w[1] - by_a[1] * by_w[0] > 0.0)
