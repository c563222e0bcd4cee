"""The descent that fits an FMU's parameters: the problem as one point, and where it ends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from servosight.identify.foreign._joint import EffectsAround
from servosight.identify.foreign._own import bounds_of, first_guess, predicted
from servosight.identify.search import LevenbergMarquardt, drive
from servosight.models.core import Array, InputError
from servosight.models.fmu import FmuModel, FmuRun, FmuVariable

BUDGET = 600
"""Runs of the FMU on all recordings."""
_STARTS = 3
"""How many of the effects' guesses are followed down."""
_FAILED_DEG = 1e6
"""The residual where a run fails: that point is not taken."""


@dataclass(frozen=True, kw_only=True)
class Search:
    """The shared parameters, then the own ones of each recording, as one point."""

    model: FmuModel | EffectsAround
    runs: tuple[FmuRun, ...]
    shared: tuple[FmuVariable, ...]
    held: Mapping[str, float]

    def starts(self) -> Array:
        """The FMU's own values, and what the recordings say of their own: (starts, coordinates).

        With effects around it, the best of their guesses.
        """
        first = [one.start or 0.0 for one in self.shared]
        own = [first_guess(run.recording, self.model) for run in self.runs]
        start = np.concatenate([first, *own])
        if not isinstance(self.model, EffectsAround):
            return start[None, :]
        points = []
        for guess in self.model.guesses([run.recording for run in self.runs]):
            guessed = [guess.get(one.name, one.start or 0.0) for one in self.shared]
            points.append(np.concatenate([guessed, *own]))
        low, high, _ = self.bounds()
        table = np.clip(points, low, high)
        costs = np.sum(self.residuals(table) ** 2, axis=1)
        return np.asarray(table[np.argsort(costs, kind="stable")[:_STARTS]])

    def bounds(self) -> tuple[Array, Array, Array]:
        """Low, high and size of a change that matters, (coordinates,) each."""
        return bounds_of([*self.shared, *self.model.own * len(self.runs)])

    def check(self, start: Array) -> None:
        """Raise InputError where the FMU does not run at the start."""
        for run, (names, rows) in zip(self.runs, self._rows(start[None, :]), strict=True):
            _, errors = predicted(self.model, run, names, rows)
            if errors[0]:
                raise InputError(
                    f"{self.model.fmu.path}: does not run on {run.recording.name} ({errors[0]}), "
                    f"expected an FMU that does; try it in the tool it is of"
                )

    def residuals(self, points: Array) -> Array:
        """Predicted minus measured [deg], (points, samples of all recordings)."""
        parts = []
        for run, (names, rows) in zip(self.runs, self._rows(points), strict=True):
            angles, _ = predicted(self.model, run, names, rows)
            parts.append(angles - run.recording.angle_deg)
        return np.nan_to_num(np.hstack(parts), nan=_FAILED_DEG)

    def _rows(self, points: Array) -> list[tuple[list[str], Array]]:
        """Names and rows of parameters of each recording."""
        shared, own = len(self.shared), len(self.model.own)
        names = [one.name for one in (*self.shared, *self.model.own)] + list(self.held)
        held = np.tile(list(self.held.values()), (len(points), 1))
        found = []
        for i in range(len(self.runs)):
            begin = shared + i * own
            rows = np.hstack([points[:, :shared], points[:, begin : begin + own], held])
            found.append((names, rows))
        return found


@dataclass(frozen=True, kw_only=True)
class End:
    """Where the search ended: (coordinates,), (samples,) [deg] and (samples, coordinates)."""

    point: Array
    residuals: Array
    jacobian: Array
    stopped: str
    evaluations: int


def descent(search: Search) -> End:
    """From the FMU's own values down; InputError where it does not run there."""
    starts = search.starts()
    search.check(starts[0])
    ends = [
        drive(LevenbergMarquardt(start, *search.bounds()), search.residuals, BUDGET)
        for start in starts
    ]
    outcome = min(ends, key=lambda end: float(end.cost))
    final = LevenbergMarquardt(outcome.point, *search.bounds())
    points = final.ask()
    residuals = search.residuals(points)
    final.tell(points, residuals)
    assert final.jacobian is not None
    return End(
        point=outcome.point,
        residuals=residuals[0],
        jacobian=final.jacobian,
        stopped=str(outcome.stopped),
        evaluations=sum(end.evaluations for end in ends),
    )
