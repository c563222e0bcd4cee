"""From the top: a rich model of a servo fitted jointly, then each effect left out in turn.

A real servo has four to six effects at a time, of which some gain nothing before others are there.
A search that adds one after the other from the linear model stops before such a set.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from servosight.diagnose.selection._steps import SearchEffort
from servosight.diagnose.selection.search._visited import Visited
from servosight.diagnose.selection.trials import ModelSelection, Trial
from servosight.models.core import StageProgress

TOGETHER = 2
"""So many of the first ordinary effects stay in any case: weight and the friction that it causes
may both gain nothing alone."""


@dataclass(frozen=True)
class BackwardSearch:
    """Models to fit, those visited, how much is tried, and the progress shown."""

    models: ModelSelection
    visited: Visited
    effort: SearchEffort
    progress: StageProgress

    def search(self, base: Trial) -> None:
        """Visit the rich model that extends ``base``, and what is left of it effect by effect."""
        self.reduce(self.rich(base, self.visited.criterion.policy.ordinary))

    def search_unloaded(self) -> bool:
        """The same with k held at 1; True where the data do not ask for another k.

        Weight, load-dependent friction and k can stand in for one another: one run at one gain has
        fits with all three wrong. With k held the others are determined, and from there k is
        fitted, too. Held, the model has a parameter less.
        """
        criterion, known = self.visited.criterion, self.models.known
        linear = self.models.unloaded()
        if linear is None:
            return False
        first, candidates = criterion.policy.ordinary[:TOGETHER], self.models.candidates(linear)
        allowed = [name for name in first if name in candidates]
        begun = tuple(dict.fromkeys((*known.first, *allowed)))
        if not begun:
            return False
        self.progress("rich model with k held", 0, len(criterion.policy.ordinary))
        others = [name for name in criterion.policy.ordinary if name not in begun]
        self.reduce(self.rich(self.models.together(linear, begun), others))
        held = [one for one in self.visited.ranked() if one.held == linear.held]
        best = self.models.finished(held[0])
        released = self.models.refitted(best)
        better = criterion.earns(best.score, self.models.first().score, 1)
        return better and not criterion.frees(released.score, best.score)

    def rich(self, base: Trial, names: Sequence[str]) -> Trial:
        """``base`` with those effects of an ordinary servo that the fitted data move.

        They are fitted together: each is added to all before it, and all parameters follow.
        """
        trial = base
        for i, name in enumerate(names):
            if name not in self.models.candidates(trial) or self.effort.is_spent(self.models):
                continue
            self.progress(f"rich model: trying {name}", i, len(names))
            larger = self.models.extended(trial, name)
            needed = name in self.visited.criterion.policy.ordinary[:TOGETHER]
            if needed or self.visited.criterion.learnt(larger.score, trial.score):
                trial = larger
        return self.models.finished(trial)

    def reduce(self, trial: Trial) -> None:
        """Leave out one effect after the other, each time the one that is missed least.

        It ends where all simulations are spent, or where what is left is dearer than the cheapest
        of its line by two effects' prices.
        """
        least = self.visited.price(trial)
        while len(trial.effects) > 1 and (names := self.visited.removable(trial)):
            if self.effort.is_spent(self.models):
                return
            smaller = []
            for i, name in enumerate(names):
                self.progress(f"trying without {name}", i, len(names))
                smaller.append(self.visited.without(trial, name))
            trial = min(smaller, key=self.visited.price)
            least = min(least, self.visited.price(trial))
            if self.visited.price(trial) > least + 2.0 * self.visited.criterion.policy.effect_price:
                break
