"""Recordings whose angles lag their commands by different times, which no effect explains."""

from __future__ import annotations

from collections.abc import Sequence

from servosight.diagnose.residuals import VALIDATION
from servosight.diagnose.selection.trials import ModelSelection
from servosight.identify.fit import OwnLatencies, Solution, clear_latencies, polish
from servosight.identify.problem import Problem, linear_start

REMEDY = (
    "it is diagnosed with its angles earlier by as much: give latency_s = {late_s} in its "
    "recording.toml if that holds for it always"
)


def own_latencies(models: ModelSelection, runs: Sequence[int]) -> OwnLatencies | None:
    """The latencies of the fitted and the carried recordings where they clearly differ.

    Seen by the first model in the samples that fit and choose, never in those of the test.
    ``runs`` (recordings,) numbers the run that each of them is a part of.
    """
    if len(set(runs)) < 2:
        return None
    return clear_latencies(_fit_to_all(models), runs)


def _fit_to_all(models: ModelSelection) -> Solution:
    """The first model; where recordings validate, the linear one fitted to them as well."""
    split = models.split
    if not split.carried:
        return models.first().fit
    masks = (*split.masks, *(uses == VALIDATION for uses in split.carried_uses))
    problem = Problem.of(
        (*split.recordings, *split.carried), models.catalogue, (), masks, models.ranges,
        models.held, models.work,
    )  # fmt: skip
    return polish(problem, [linear_start(problem)])
