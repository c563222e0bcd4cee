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
    whole_deg: Mapping[tuple[str, ...], Array] | None = None,
) -> tuple[ModelSelection, list[Trial]]:
    """Models with these effects and errors (samples,) on a recording, none of them fitted.

    ``whole_deg`` are errors of fits to the validation samples as well, where they differ.
    """
    models = ModelSelection(Split.of([recording]), catalogue(), known or PriorKnowledge())
    found = []
    for effects, error in errors_deg.items():
        problem = models.problem(effects)
        point = np.clip(np.zeros(len(problem.coordinates)), *problem.bounds)
        fit, uses = Solution.at(problem, point), models.split.uses[0]
        one, whole = (
            Trial(problem.effects, fit, (Judged(recording, recording.angle_deg - made, uses),))
            for made in (error, (whole_deg or {}).get(effects, error))
        )
        found.append(one)
        models.trials[one.key] = one
        models.wholes[one.key, fit.outcome.cost] = whole
    return models, found
