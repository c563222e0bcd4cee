"""Progress of a selection: what is tried, and the best answer so far."""

from __future__ import annotations

from dataclasses import dataclass

from servosight.diagnose.selection.search._visited import Visited
from servosight.models.core import StageProgress


@dataclass(frozen=True)
class BestSoFar:
    """Shows each stage with the model of the lowest price that was fitted before it."""

    visited: Visited
    shown: StageProgress

    def __call__(self, stage: str, done: int, total: int | None = None) -> None:
        """Show a stage, what is done and of how much."""
        ranked = self.visited.ranked()
        if ranked:
            best = ranked[0]
            named = " + ".join(best.effects).replace("_", " ") or "the linear model"
            stage = f"{stage}; best so far: {named}, {best.score.validation_rmse_deg:.3g} deg"
        self.shown(stage, done, total)
