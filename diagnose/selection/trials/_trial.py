"""A set of effects fitted to recordings, and its score."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from servosight.diagnose.residuals import FIT, TEST, VALIDATION, Judged, rms
from servosight.diagnose.selection._blocks import squares_by_block
from servosight.diagnose.selection._score import Score
from servosight.identify.fit import Solution
from servosight.identify.problem import Coordinate, Problem
from servosight.models.core import CORE, Array

_FAR = 5.0  # times an error: short fits that went on have come down to a third at most

Key = tuple[tuple[str, ...], tuple[str, ...]]
"""Effects, and the parameters that are held."""


def key_of(problem: Problem) -> Key:
    """What tells a model from others of the same selection."""
    return problem.effects, tuple(sorted(problem.held))


@dataclass(frozen=True)
class Trial:
    """A fitted set of effects and its predictions.

    ``judged`` lists the recordings that were fitted, then those that only validate.
    """

    effects: tuple[str, ...]
    fit: Solution
    judged: tuple[Judged, ...]

    @property
    def key(self) -> Key:
        """Its effects and what is held."""
        return key_of(self.fit.problem)

    @property
    def held(self) -> tuple[str, ...]:
        """The parameters that are held."""
        return self.key[1]

    @cached_property
    def score(self) -> Score:
        """What it amounts to on the fitted samples and those validation samples that choose.

        Without any of these the fitted ones stand in for them.
        """
        choosing = [one.choosing for one in self.judged]
        validation = _validation(choosing)
        seen = [one.error_deg[one.uses != TEST] for one in choosing]
        return Score(
            effects=self.effects,
            parameters=self.fit.problem.fitted,
            samples=sum(errors.size for errors in seen),
            mean_square_deg2=rms(seen) ** 2,
            train_rmse_deg=rms([one.errors_of(FIT) for one in self.judged]),
            validation_rmse_deg=rms(validation),
            validation_samples=sum(errors.size for errors in validation),
            at_bounds=_at_bounds(self.fit),
            gain_fitted="k" not in self.fit.problem.held,
            core_at_bounds=_core_at_bounds(self.fit),
            blocks_deg2=squares_by_block(choosing),
        )

    @cached_property
    def validation_errors_deg(self) -> Array:
        """The errors of all validation samples, those that do not choose included."""
        return np.concatenate([np.empty(0), *_validation(self.judged)])

    @property
    def validation_rmse_deg(self) -> float:
        """Root mean square of ``validation_errors_deg``; the score's is of those that choose."""
        return rms([self.validation_errors_deg])


def key_less(trial: Trial, name: str) -> Key:
    """The key of a model less one effect."""
    return tuple(own for own in trial.effects if own != name), trial.held


def is_far(trial: Trial, better: Trial) -> bool:
    """True where ``trial``, after a short fit, errs so much more than a ``better`` one that it is
    not worth fitting to its end."""
    return trial.score.train_rmse_deg > _FAR * better.score.train_rmse_deg


def _validation(judged: Sequence[Judged]) -> list[Array]:
    """The errors of the validation samples; of the fitted ones where there are none."""
    errors = [one.errors_of(VALIDATION) for one in judged]
    return errors if any(one.size for one in errors) else [one.errors_of(FIT) for one in judged]


def _at_bounds(fit: Solution) -> tuple[str, ...]:
    """The effects with a parameter on a bound of its range that is neither zero nor neutral.

    Nor the shortest of its times: it then acts at once, as a supply does whose wires alone resist.
    """
    found = []
    for coordinate, place, low in _on_bounds(fit):
        effect, _, own = coordinate.name.partition(".")
        parameter = coordinate.parameter
        if not own or parameter.circular or (parameter.unit == "s" and place == low):
            continue
        if coordinate.from_search(place) not in (0.0, parameter.neutral):
            found.append(effect)
    return tuple(dict.fromkeys(found))


def _core_at_bounds(fit: Solution) -> tuple[str, ...]:
    """Of k, T and xi those on a bound of their range."""
    core = {parameter.name for parameter in CORE}
    return tuple(one.name for one, *_ in _on_bounds(fit) if one.name in core)


def _on_bounds(fit: Solution) -> Iterator[tuple[Coordinate, float, float]]:
    """The coordinates that are fitted and rest on a bound; where they are, and the lower bound."""
    problem = fit.problem
    places = zip(
        problem.coordinates, fit.outcome.point, *problem.bounds, problem.is_held, strict=True
    )
    for coordinate, place, low, high, is_held in places:
        if not is_held and not low < place < high:
            yield coordinate, float(place), float(low)
