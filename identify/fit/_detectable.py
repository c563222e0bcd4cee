"""Whether these recordings could have shown an effect at all, and from which size on.

A motion that never reverses shows no play, and one that stays slow no limit of the speed: such an
effect is neither found nor ruled out. So each effect is added to the first model in growing sizes,
simulated with the recordings' own commands; what the model's parameters cannot take up of the
change must be as large as the caller asks for. No measured angle enters but through the model.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.identify.fit._solution import Solution
from servosight.identify.problem import Problem, effect_guesses, neutral_start, projected_out
from servosight.models.core import Array, Parameter, rounded, with_article

COUNT = 9
"""Sizes that are simulated, from a small share of the first guess up to the parameter's bound."""
AT_ONCE = 2
"""Number of sizes that are simulated at a time, until one of them shows."""
SMALL = 1.0 / 64.0
LEAST_REACH = 1e-4
"""A guess this close to neutral, as a share of the way to the bound, says nothing of the size."""


@dataclass(frozen=True, kw_only=True)
class Detectable:
    """The smallest size of an effect that these recordings would have shown.

    ``parameter`` at ``value`` [``unit``] is where it begins to show: from there on, away from its
    neutral value, or ``below`` it for a limit, whose neutral value is infinite. ``value`` is None
    where no size within the parameter's bounds shows: the recordings say nothing on this effect.
    """

    effect: str
    parameter: str
    unit: str
    value: float | None
    below: bool
    sentence: str


def size_shown(
    name: str, problem: Problem, base: Solution, least_deg: float, still: bool = False
) -> Detectable:
    """The smallest size of an effect whose change of the angle is ``least_deg`` rms.

    ``problem`` is that of ``base`` and the effect ``name``; ``still`` where no motion reverses. Of
    the change only the part counts that the parameters of ``base`` cannot produce.
    """
    start = neutral_start(problem, base.as_base)
    guess = effect_guesses(problem, base.as_base)[0]
    low, high = problem.bounds
    sized = [
        j
        for j, coordinate in enumerate(problem.coordinates)
        if coordinate.name.partition(".")[0] == name and coordinate.parameter.neutral is not None
    ]
    # Of several sizes those move that the guess moves, and the first of them is reported.
    away = np.zeros(guess.size)
    away[sized] = (guess - start)[sized]
    measured = np.array([not c.parameter.free_unit for c in problem.coordinates])
    away[measured & (np.abs(away) <= LEAST_REACH * (high - low))] = 0.0
    place = next((j for j in sized if away[j] != 0.0), sized[0])
    if away[place] == 0.0:
        up = high[place] - start[place] > start[place] - low[place]
        away[place] = LEAST_REACH * (high[place] - low[place]) * (1.0 if up else -1.0)
    bound = high[place] if away[place] > 0.0 else low[place]
    most = float((bound - start[place]) / away[place])
    sizes = np.geomspace(min(SMALL, 0.5 * most), most, COUNT)
    varied = np.where(np.isin(np.arange(guess.size), sized), start, guess)
    points = np.clip(varied + sizes[:, None] * away, low, high)
    changes_deg = _changes_deg(problem, base, points, least_deg)
    size = smallest(sizes[: changes_deg.size], changes_deg, least_deg)
    main = problem.coordinates[place]
    value = None if size is None else main.from_search(float(start[place] + size * away[place]))
    return Detectable(
        effect=name,
        parameter=main.name.partition(".")[2],
        unit=main.parameter.unit,
        value=value,
        below=main.parameter.reciprocal,
        sentence=_words(name, main.parameter, value, still),
    )


def _changes_deg(problem: Problem, base: Solution, points: Array, least_deg: float) -> Array:
    """Rms change that the parameters of ``base`` cannot produce, at one of ``points`` after the
    other, until one reaches ``least_deg``: the larger sizes cost the longest simulations."""
    found = np.empty(0)
    for first in range(0, len(points), AT_ONCE):
        changes = problem.residuals(points[first : first + AT_ONCE]) - base.residual
        left = projected_out(changes.T, base.jacobian)
        found = np.append(found, np.sqrt(np.mean(left**2, axis=0)))
        if found.max() >= least_deg:
            break
    return found


def smallest(sizes: Array, change_deg: Array, least_deg: float) -> float | None:
    """The smallest size whose change reaches ``least_deg``, (sizes,) each; None where none does.

    Straight lines between logarithms.

    >>> smallest(np.array([1.0, 10.0]), np.array([0.01, 0.1]), 0.05)
    5.0
    """
    reached = np.flatnonzero(change_deg >= least_deg)
    if not reached.size:
        return None
    at = int(reached[0])
    if at == 0 or change_deg[at - 1] <= 0.0:
        return float(sizes[at])
    x, y = np.log(sizes[at - 1 : at + 1]), np.log(change_deg[at - 1 : at + 1])
    part = (np.log(least_deg) - y[0]) / max(float(y[1] - y[0]), 1e-12)
    return round(float(np.exp(x[0] + part * (x[1] - x[0]))), 12)


def _words(name: str, parameter: Parameter, value: float | None, still: bool) -> str:
    effect = with_article(name)
    if value is None:
        motion = "the motion, which never reverses," if still else "the motion"
        return f"{effect} could not have shown: {motion} does not excite it"
    unit = parameter.suffix
    neutral = parameter.neutral or 0.0
    if parameter.reciprocal:
        size = f"below {rounded(value, 2)}{unit}"
    elif parameter.low < neutral:
        off = f"{rounded(abs(value - neutral), 2)}{unit}"
        size = f"from ± {off}" if neutral == 0.0 else f"from {off} above or below {neutral:g}"
    else:
        size = f"from {rounded(value, 2)}{unit}"
    return f"{effect} would have shown {size} ({parameter.meaning})"
