"""Models that are not fitted, with errors that are given."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from servosight.diagnose.residuals import Judged
from servosight.diagnose.selection import ModelSelection, PriorKnowledge, Split, Trial
from servosight.identify.fit import Solution
from servosight.models.core import Array, Recording
from servosight.models.effects import catalogue


def unfitted(
    recording: Recording,
    errors_deg: Mapping[tuple[str, ...], Array],
    known: PriorKnowledge | None = None,
) -> tuple[ModelSelection, list[Trial]]:
    """Models with these effects and errors (samples,) on a recording, none of them fitted."""
    models = ModelSelection(Split.of([recording]), catalogue(), known or PriorKnowledge())
    found = []
    for effects, error in errors_deg.items():
        problem = models.problem(effects)
        point = np.clip(np.zeros(len(problem.coordinates)), *problem.bounds)
        judged = (Judged(recording, recording.angle_deg - error, models.split.uses[0]),)
        found.append(Trial(problem.effects, Solution.at(problem, point), judged))
        models.trials[found[-1].key] = found[-1]
    return models, found
