"""Which terms a missing torque may have, to first order: orthogonal matching pursuit.

Pati, Rezaiifar and Krishnaprasad 1993, with the torques' answers through the loop as dictionary, so
that the noise stays the measurement's own; a derivative of the angle is never taken.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from servosight.diagnose.discrepancy._disturbance import DisturbanceEstimator
from servosight.diagnose.discrepancy.basis import (
    DRIVES,
    FRICTIONS,
    LOADS,
    TIMES,
    BasisTerm,
    Extent,
    Point,
)
from servosight.diagnose.selection import Trial
from servosight.identify.problem import Problem
from servosight.models.core import Array

TERMS: Mapping[str, BasisTerm] = {
    term.effect.id: term for term in (*LOADS, *TIMES, *DRIVES, *FRICTIONS)
}
"""The terms that a law can have."""

PROMISING = 3
"""Number of the loads, of the drives and of the frictions that are tried: the most promising."""
_BLOCK = 64


@dataclass(frozen=True)
class TermCandidate:
    """A term that promises much: its cost to first order (less is better), the parameters that it
    starts with, and by how much the model's own coordinates would follow."""

    cost: float
    name: str
    start: Point
    shift: Array


def promising(
    trial: Trial, terms: Mapping[str, BasisTerm], count: int, noise_deg: float
) -> list[TermCandidate]:
    """Forms of each kind that would lower the residual most to first order, best first."""
    fit = trial.fit
    problem = fit.problem
    residual = fit.residual
    basis, corner = np.linalg.qr(fit.jacobian)
    left = residual - basis @ (basis.T @ residual)
    estimators = [
        DisturbanceEstimator.of(trial, number, noise_deg, with_test=False)
        for number in range(count)
    ]
    extent = Extent.of(
        [estimator.motion for estimator in estimators], problem.values(fit.outcome.point)["T"]
    )
    found = []
    for name, term in terms.items():
        if name in trial.effects:
            continue
        best: tuple[float, Point, Array] | None = None
        grid = term.grid(extent)
        for first in range(0, len(grid), _BLOCK):
            part = grid[first : first + _BLOCK]
            answers = _answers(term, part, estimators, problem)
            own = answers - (answers @ basis) @ basis.T
            best = _better(best, term, part, answers, own, left)
        if best is not None:
            gain, start, change = best
            shift = -np.linalg.lstsq(corner, basis.T @ (residual + change), rcond=1e-9)[0]
            free = max(float(left @ left) - gain, 1e-12)
            size = 0.5 * left.size * float(np.log(free / left.size + noise_deg**2))
            cost = size + 0.5 * len(term.effect.parameters) * float(np.log(left.size))
            found.append(TermCandidate(cost, name, start, shift))
    # A loop that was fitted without friction has taken most of it for damping: what promises less
    # may still be right, so that each kind has its best tried.
    chosen = []
    for kind in ((*LOADS, *TIMES), DRIVES, FRICTIONS):
        names = {term.effect.id for term in kind}
        chosen += sorted((one for one in found if one.name in names), key=_cost)[:PROMISING]
    return sorted(chosen, key=_cost)


def _cost(candidate: TermCandidate) -> float:
    return candidate.cost


def _answers(
    term: BasisTerm,
    grid: Sequence[Point],
    estimators: Sequence[DisturbanceEstimator],
    problem: Problem,
) -> Array:
    """Changes of the weighted residual, (grid, coefficients, scored), for coefficients of 1."""
    parts = []
    for estimator, recording, weight, mask in zip(
        estimators, problem.recordings, problem.weights, problem.masks, strict=True
    ):
        torques = np.array([term.shapes(estimator.motion, *at) for at in grid])
        for j, parameter in enumerate(term.effect.parameters[: torques.shape[1]]):
            torques[:, j] *= parameter.scaling.factor(
                recording.relative_gain, recording.relative_load
            )
        flat = estimator.answers(torques.reshape(-1, torques.shape[-1]))
        scored = (flat[:, estimator.at] * weight)[:, mask]
        parts.append(scored.reshape(*torques.shape[:2], -1))
    return np.concatenate(parts, axis=2)


def _better(
    best: tuple[float, Point, Array] | None,
    term: BasisTerm,
    grid: Sequence[Point],
    answers: Array,
    own: Array,
    left: Array,
) -> tuple[float, Point, Array] | None:
    """The largest gain so far, its start and its change, after one more block of the grid.

    ``own`` are the answers without what the model's parameters can do.
    """
    size = np.linalg.norm(own, axis=2) + 1e-12
    unit = own / size[..., None]
    normal = unit @ unit.transpose(0, 2, 1) + 1e-9 * np.eye(unit.shape[1])
    agree = -(unit @ left)
    coefficients = np.linalg.solve(normal, agree[..., None])[..., 0]
    gains = np.einsum("ij,ij->i", coefficients, agree)
    for index in np.argsort(-gains):
        found = coefficients[index] / size[index]
        start = term.start(found, grid[index])
        if start is not None:
            if best is None or gains[index] > best[0]:
                best = (float(gains[index]), start, found @ answers[index])
            break
    return best
