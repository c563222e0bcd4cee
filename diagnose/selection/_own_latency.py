"""Recordings whose angles lag their commands by different times, which no effect explains."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from servosight.diagnose.residuals import VALIDATION
from servosight.diagnose.selection.trials import ModelSelection, Trial, own_point
from servosight.identify.fit import DEAD_TIME, OwnLatencies, Solution, clear_latencies, polish
from servosight.identify.problem import Problem

WORTH = 0.25
"""A latency is taken out before anything is fitted where the error falls by this share. Where much
else is missing, a latency stands in for some of it: in five of 16 of BAM's servos for 5 to 9 %."""
REMEDY = (
    "it is diagnosed with its angles earlier by as much: give latency_s = {late_s} in its "
    "recording.toml if that holds for it always"
)
LEFT = (
    "the models take them for the same: give latency_s = {late_s} in its recording.toml and "
    "diagnose again"
)


def own_latencies(
    models: ModelSelection, runs: Sequence[int], rich: Callable[[], Trial]
) -> OwnLatencies | None:
    """The latencies of the fitted and the carried recordings where they clearly differ.

    Seen in the samples that fit and choose, never in those of the test, and a good part of the
    error, of the first model and then of the ``rich`` one: a recording that alone reaches a limit
    of the servo seems late, and a latency that stands for the limit hides it from all models.
    ``runs`` (recordings,) numbers the run that each of them is a part of.
    """
    if len(set(runs)) < 2 or _seen_by(models, models.first(), runs) is None:
        return None
    return _seen_by(models, rich(), runs)


def _seen_by(models: ModelSelection, model: Trial, runs: Sequence[int]) -> OwnLatencies | None:
    """The latencies that a good part of a model's error goes with."""
    found = clear_latencies(fitted_to_all(models, model), runs)
    most = found is not None and found.rmse_deg <= (1.0 - WORTH) * found.shared_rmse_deg
    return found if most else None


def latencies_left(models: ModelSelection, last: Trial, names: Sequence[str]) -> tuple[str, ...]:
    """A sentence for each fitted recording that clearly lags others where the last model ends.

    ``names`` (recordings,) are those of the runs that each is a part of. Without the dead time that
    the servo has, recordings of fast motion seem later than those of slow motion: so none where the
    model would not say so with it.
    """
    own = names[: len(last.fit.problem.recordings)]
    runs = [own.index(name) for name in own]
    found = clear_latencies(last.fit, runs)
    if found is None:
        return ()
    if DEAD_TIME in models.candidates(last):
        found = clear_latencies(models.extended(last, DEAD_TIME).fit, runs)
    return () if found is None else found.sentences(own, LEFT)


def fitted_to_all(models: ModelSelection, model: Trial) -> Solution:
    """A model's fit; where recordings validate, to these as well."""
    split = models.split
    if not split.carried:
        return model.fit
    validating = tuple(np.asarray(uses == VALIDATION) for uses in split.carried_uses)
    problem = Problem.of(
        (*split.recordings, *split.carried), models.catalogue, model.effects,
        (*split.masks, *validating), models.ranges, model.fit.problem.held, models.work,
    )  # fmt: skip
    physical = model.fit.outcome.point[: model.fit.problem.physical]
    start = [model.fit.outcome.point]
    for recording, mask in zip(split.carried, validating, strict=True):
        alone = Problem.of([recording], models.catalogue, model.effects, [mask])
        start.append(own_point(recording, alone, physical)[alone.physical :])
    return polish(problem, [np.concatenate(start)])
