"""From the top: a rich model of a servo fitted jointly, then each effect left out in turn.

A real servo has four to six effects at a time, of which some gain nothing before others are there.
A search that adds one after the other from the linear model stops before such a set.
"""

from __future__ import annotations

from dataclasses import dataclass

from servosight.diagnose.selection._models import ModelSelection
from servosight.diagnose.selection._trial import Trial
from servosight.diagnose.selection.search._visited import Visited
from servosight.models.core import StageProgress

TOGETHER = 2
"""So many of the first ordinary effects stay in any case: weight and the friction that it causes
may both gain nothing alone."""


@dataclass(frozen=True)
class BackwardSearch:
    """Models to fit, those visited, and the progress shown."""

    models: ModelSelection
    visited: Visited
    progress: StageProgress

    def search(self, base: Trial) -> None:
        """Visit the rich model that extends ``base``, and what is left of it effect by effect."""
        self.reduce(self.rich(base))

    def rich(self, base: Trial) -> Trial:
        """``base`` with the effects of an ordinary servo whose parameters the fitted data move.

        They are fitted together: each is added to all before it, and all parameters follow.
        """
        trial = base
        ordinary = self.visited.criterion.policy.ordinary
        for i, name in enumerate(ordinary):
            if name not in self.models.candidates(trial):
                continue
            self.progress(f"rich model: trying {name}", i, len(ordinary))
            larger = self.models.extended(trial, name)
            if i < TOGETHER or self.visited.criterion.learnt(larger.score, trial.score):
                trial = larger
        return self.models.finished(trial)

    def reduce(self, trial: Trial) -> None:
        """Leave out one effect after the other, each time the one that is missed least.

        It ends where what is left is dearer than the cheapest of its line by two effects' prices.
        """
        least = self.visited.price(trial)
        while len(trial.effects) > 1 and (names := self.visited.removable(trial)):
            smaller = []
            for i, name in enumerate(names):
                self.progress(f"trying without {name}", i, len(names))
                smaller.append(self.visited.without(trial, name))
            trial = min(smaller, key=self.visited.price)
            least = min(least, self.visited.price(trial))
            if self.visited.price(trial) > least + 2.0 * self.visited.criterion.policy.effect_price:
                break
