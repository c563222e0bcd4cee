"""Progress of a selection: what is tried, and the best answer whenever there is a better one."""

from __future__ import annotations

from dataclasses import dataclass, field

from servosight.diagnose.selection.search._visited import Visited
from servosight.models.core import BEST_SO_FAR, StageProgress, degrees, spoken, times


@dataclass
class BestSoFar:
    """Shows each stage; before it the best-ranked model, where that is another one now."""

    visited: Visited
    shown: StageProgress
    best: str = field(default="", init=False)

    def __call__(self, stage: str, done: int, total: int | None = None) -> None:
        """Show a stage, what is done and of how much."""
        best = self._words()
        if best != self.best:
            self.best = best
            self.shown(best, 0, 1)
        self.shown(stage, done, total)

    def _words(self) -> str:
        """The best model by its effects, with its error; empty where none was fitted."""
        ranked = self.visited.ranked()
        if not ranked:
            return ""
        named = " + ".join(map(spoken, ranked[0].effects)) or "the linear model"
        error, floor = ranked[0].score.validation_rmse_deg, self.visited.criterion.floor_deg
        return (
            f"{BEST_SO_FAR}{named}, {degrees(error)} rms on validation data, "
            f"{times(error / max(floor, 1e-12))} times the floor of {degrees(floor)}"
        )
