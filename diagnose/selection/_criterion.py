"""Decisions of the model selection: from the scores of fitted models to what is added or removed.

Nothing here fits or simulates. The functions of :class:`AcceptanceCriterion` compare scores. All
thresholds are in :class:`SelectionPolicy` (``_policy.py``).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from scipy.special import chdtri, fdtri

from servosight.diagnose.selection._blocks import FEWEST_BLOCKS, is_above, log_ratios
from servosight.diagnose.selection._policy import SelectionPolicy
from servosight.diagnose.selection._score import Score
from servosight.models.core import Array

T = TypeVar("T")


@dataclass(frozen=True)
class AcceptanceCriterion:
    """What a model must meet on the given data.

    ``floor_deg`` is the smallest error that counts, the measurement's noise and the tolerance
    together; ``tolerance_deg`` is the part of it that no model is asked to be right within.
    ``worth`` is how many independent samples of such an error one sample is worth, and ``freedom``
    how many the floor is known from.

    >>> criterion = AcceptanceCriterion(0.03, 0.01)
    >>> small = Score(
    ...     effects=(), parameters=3, samples=900, mean_square_deg2=0.25, train_rmse_deg=0.5,
    ...     validation_rmse_deg=0.5, validation_samples=150, gain_fitted=True)
    >>> large = Score(
    ...     effects=("backlash",), parameters=4, samples=900, mean_square_deg2=0.0009,
    ...     train_rmse_deg=0.03, validation_rmse_deg=0.03, validation_samples=150, gain_fitted=True)
    >>> criterion.earns(large, small, tried=21)
    True
    """

    floor_deg: float
    tolerance_deg: float
    policy: SelectionPolicy = field(default_factory=SelectionPolicy)
    worth: float = 1.0
    freedom: float = np.inf

    def value(self, score: Score) -> float:
        """Log-likelihood with parameters counted (half the negative BIC, Schwarz 1978).

        Errors below the tolerance do not count: the tolerance adds to the mean square.
        """
        return self._value(score, score.samples, score.mean_square_deg2)

    def _value(self, score: Score, count: int, mean_square_deg2: float) -> float:
        variance = mean_square_deg2 + self.tolerance_deg**2
        size = -0.5 * count * float(np.log(max(variance, 1e-300)))
        return size - 0.5 * score.parameters * float(np.log(count))

    def evidence(self, score: Score, base: Score) -> float:
        """How much ``score`` gains on ``base`` in log-likelihood; positive is better."""
        return self.value(score) - self.value(base)

    def fitted_evidence(self, score: Score, base: Score) -> float:
        """The same on the fitted samples alone."""
        one, other = (
            self._value(each, each.samples - each.validation_samples, each.train_rmse_deg**2)
            for each in (score, base)
        )
        return one - other

    def at_floor(self, rmse_deg: float, samples: int) -> bool:
        """True where an error is within 10 % of the floor, or of few samples within chance.

        By chance only does the mean square of n samples exceed the floor's by more than the
        quantile 1 - chance of F(n, ``freedom``), which is chi2(n) / n for a floor that is known.
        """
        count = max(samples * self.worth, 1.0)
        if np.isinf(self.freedom):
            square = chdtri(count, self.policy.chance) / count
        else:
            square = fdtri(count, self.freedom, 1.0 - self.policy.chance)
        return rmse_deg <= max(self.policy.explained, float(np.sqrt(square))) * self.floor_deg

    def explained(self, score: Score) -> bool:
        """True where the validation error is at the floor."""
        return self.at_floor(score.validation_rmse_deg, score.validation_samples)

    def leaves_structure(self, score: Score) -> bool:
        """True where a model errs more than the noise makes, even if within the tolerance."""
        noise_deg = float(np.sqrt(max(self.floor_deg**2 - self.tolerance_deg**2, 0.0)))
        return score.larger_rmse_deg > self.policy.structure * noise_deg

    def is_closer(self, score: Score, rival: Score) -> bool:
        """True where a model errs clearly less than another one that explains data within the
        tolerance, but not down to the noise."""
        most = self.policy.closer
        fitted = score.train_rmse_deg <= most * rival.train_rmse_deg
        other = score.validation_rmse_deg <= most * rival.validation_rmse_deg
        distinct = self.evidence(score, rival) >= self.policy.undecided
        return fitted and other and distinct and self.leaves_structure(rival)

    @property
    def enough_deg(self) -> float:
        """The rms error of fitted samples that is at the floor [deg]."""
        return self.policy.explained * self.floor_deg

    def settled(self, score: Score) -> bool:
        """True where the error of the fitted samples is at the floor."""
        return score.train_rmse_deg <= self.enough_deg

    def done(self, score: Score) -> bool:
        """True where a model is at the floor on fitted and on validation samples.

        What is missing may show in a few seconds only, all of which were fitted.
        """
        return self.explained(score) and self.settled(score)

    def closed(self, score: Score, base: Score) -> float:
        """Share of the squared validation error above the floor that ``score`` takes off."""
        before, after = base.validation_rmse_deg**2, score.validation_rmse_deg**2
        return (before - after) / max(before - self.floor_deg**2, 1e-300)

    def learnt(self, score: Score, base: Score) -> bool:
        """True where the fitted samples have determined what ``score`` has and ``base`` lacks."""
        return score.train_rmse_deg <= (1.0 - self.policy.learnt) * base.train_rmse_deg

    def within_bounds(self, score: Score, base: Score) -> bool:
        """True where no effect rests on a bound of its range that did not in ``base``.

        The data then ask for a value that no servo has: something else is missing.
        """
        return set(score.at_bounds) <= set(base.at_bounds)

    def is_evident(self, score: Score, base: Score, tried: int) -> bool:
        """True where the fitted samples determine what is new, within its bounds, and the evidence
        is enough for the best of so many as were ``tried``."""
        needed = self.policy.min_evidence + float(np.log(max(tried, 1)))
        learnt = self.learnt(score, base) and self.within_bounds(score, base)
        return learnt and self.evidence(score, base) >= needed

    def earns(self, score: Score, base: Score, tried: int) -> bool:
        """True where the gain shows on validation data, in degrees and in evidence.

        A real servo differs from every model a little everywhere, and with thousands of samples
        any effect gains significantly: so it must also account for a fair share of what is left.
        Where the validation samples show nothing, all samples are compared, and the validation
        error must stay at the floor. What the fitted samples show may count as well (``_shows``).
        ``tried``: among how many it was the best.
        """
        if not self.is_evident(score, base, tried):
            return False
        if self.explained(base):
            lower = self._removes(score.mean_square_deg2**0.5, base.mean_square_deg2**0.5)
            return lower and self.explained(score)
        lower = self._removes(score.validation_rmse_deg, base.validation_rmse_deg)
        return lower or self._shows(score, base)

    def _removes(self, after_deg: float, before_deg: float) -> bool:
        """True where an rms error falls by enough, also of what is above the floor."""
        gone = before_deg**2 - after_deg**2
        return (
            after_deg <= (1.0 - self.policy.min_gain) * before_deg
            and gone >= self.policy.min_share * (before_deg**2 - self.floor_deg**2)
            and gone >= (self.policy.min_removed * self.floor_deg) ** 2
        )

    def _shows(self, score: Score, base: Score) -> bool:
        """True where the fitted samples show a gain that the validation samples do not deny.

        These may hardly move what is new, beside an error of their own: they deny it where they
        rise beyond their scatter from second to second. In all samples together the gain must be
        worth its penalty beyond that.
        """
        if not self._removes(score.train_rmse_deg, base.train_rmse_deg):
            return False
        rise = self._log_ratios(score.blocks_deg2[1], base.blocks_deg2[1])
        if rise.size < FEWEST_BLOCKS:
            denied = score.validation_rmse_deg > base.validation_rmse_deg
        else:
            denied = is_above(rise)
        enough = self._log_ratios(base.blocks_deg2, score.blocks_deg2).size >= FEWEST_BLOCKS
        return enough and not denied and self.is_higher(base, score)

    def is_higher(self, score: Score, than: Score) -> bool:
        """True where the penalised error of ``score`` is higher, beyond its scatter between blocks.

        With too few blocks for a scatter it is: then no models are said to be alike.
        """
        more = self._log_ratios(score.blocks_deg2, than.blocks_deg2)
        less = self.penalty(than) - self.penalty(score)
        return more.size < FEWEST_BLOCKS or is_above(more, less)

    def _log_ratios(self, squares: Array, than: Array) -> Array:
        return log_ratios(squares, than, self.enough_deg, self.floor_deg)

    def frees(self, score: Score, held: Score) -> bool:
        """True where data ask for a parameter to be fitted that ``held`` has at a likely value.

        It must lower the error of fitted and of validation data as an effect must. Where the
        validation data are at the floor with the parameter held, it stays held.
        """
        lower = (1.0 - self.policy.min_gain) * held.validation_rmse_deg
        falls = score.validation_rmse_deg <= lower and not self.explained(held)
        return falls and self.learnt(score, held)

    def earns_as_pair(self, both: Score, rivals: Sequence[Score], tried: int) -> bool:
        """True where two effects together earn their place beside each of ``rivals``.

        These are the current model, that with the pair's first effect, and the best single one.
        """
        return all(self.earns(both, rival, tried**2) for rival in rivals)

    def beats(self, score: Score, rival: Score) -> bool:
        """True where a model is better than one built otherwise, also on validation data."""
        lower = score.validation_rmse_deg < rival.validation_rmse_deg
        return lower and self.evidence(score, rival) > 0.0

    def worth_its_parameters(self, score: Score, simple: Score) -> bool:
        """True where an effect that contains another is clearly better than that one.

        On all samples: what parts the two may show in a few of them only.
        """
        gone = simple.mean_square_deg2 - score.mean_square_deg2
        return (
            self.evidence(score, simple) >= self.policy.nested
            and gone >= (self.policy.visible * self.tolerance_deg) ** 2
            and score.validation_rmse_deg <= self.policy.worse * simple.validation_rmse_deg
        )

    def is_distinguished(self, score: Score, simple: Score) -> bool:
        """The same; where neither explains the data, more than a few seconds distinguish them."""
        able = self.worth_its_parameters(score, simple)
        return able and (self.explained(score) or self.is_higher(simple, score))

    def penalised_error(self, score: Score) -> float:
        """What models are ranked by: log rmse [deg], and a penalty for effects and parameters.

        The rmse is the larger of fitted and validation data: effects that are missing raise the
        one, too many the other. A fitted k counts as an effect. Below the floor no error is better
        than another.
        """
        return self._penalised(score, score.larger_rmse_deg)

    def overall_penalised_error(self, score: Score) -> float:
        """The same with the error of all fitted and validation samples."""
        return self._penalised(score, float(np.sqrt(score.mean_square_deg2)))

    def least_penalised_error(self, score: Score) -> float:
        """A lower bound of ``overall_penalised_error`` once validation samples are fitted too."""
        fitted = 1.0 - score.validation_samples / score.samples
        return self._penalised(score, float(np.sqrt(fitted)) * score.train_rmse_deg)

    def penalised_error_as_ordinary(self, score: Score) -> float:
        """The same as ``penalised_error`` where each effect is one that most servos have."""
        rare = sum(name not in self.policy.ordinary for name in score.effects)
        return self.penalised_error(score) - rare * (
            self.policy.rare_penalty - self.policy.effect_penalty
        )

    def _penalised(self, score: Score, error_deg: float) -> float:
        return float(np.log(max(error_deg, self.floor_deg, 1e-300))) + self.penalty(score)

    def penalty(self, score: Score) -> float:
        """What effects and parameters add to log rmse in the penalised error."""
        ordinary = sum(name in self.policy.ordinary for name in score.effects)
        effects = self.policy.effect_penalty * (ordinary + score.gain_fitted)
        effects += self.policy.rare_penalty * (len(score.effects) - ordinary)
        return effects + self.policy.parameter_penalty * score.parameters

    def clearly_lower(self, penalised_error: float, than: float) -> bool:
        """True where a penalised error is lower by so much that a search goes on."""
        return penalised_error <= than - self.policy.worth_going_on

    def near(self, penalised_error: float, least: float) -> bool:
        """True where a penalised error is within the penalty of a few effects of the least."""
        return penalised_error <= least + self.policy.near * self.policy.effect_penalty

    def wants_search(self, score: Score) -> bool:
        """True where single steps have ended far from the floor."""
        return self._far(score) and score.samples >= self.policy.fewest

    def hopeless(self, single: Score) -> bool:
        """True where the best single effect is so far from the floor that no second will do."""
        beyond = single.validation_rmse_deg > self.policy.hopeless * self.floor_deg
        return beyond and single.samples >= self.policy.fewest

    def leaves_much(self, score: Score, linear: Score) -> bool:
        """True where a model leaves so much that its first effect may be the wrong one."""
        return self._far(score) and self.closed(score, linear) < self.policy.most

    def _far(self, score: Score) -> bool:
        """True where fitted or validation data leave much: what is missing may show in one only."""
        return score.larger_rmse_deg > self.policy.far * self.floor_deg

    def wants_pairs(self, reached: Score, first: Score) -> bool:
        """True where no effect was added to the first model on its own, and one is missing."""
        return reached.effects == first.effects and not self.explained(reached)

    def tied(self, log_likelihood: float) -> bool:
        """True where a difference in log-likelihood distinguishes no two models."""
        return log_likelihood < self.policy.tie

    def undecided(self, score: Score, rival: Score) -> bool:
        """True where two models' evidence is close enough to compare them on all samples."""
        return abs(self.evidence(score, rival)) < self.policy.undecided

    def ranked(self, models: Sequence[T], score: Callable[[T], Score]) -> list[T]:
        """Best first; of equals the one with fewer parameters."""
        return sorted(models, key=lambda one: (-self.value(score(one)), score(one).parameters))

    def ordered(
        self,
        models: Sequence[T],
        score: Callable[[T], Score],
        contains: Callable[[T], Collection[str]],
        name: Callable[[T], str],
    ) -> list[T]:
        """Best first; an effect goes behind one that it contains unless it is clearly better.

        ``name`` gives the effect that a model adds, ``contains`` its special cases.
        """
        found = self.ranked(models, score)
        for model in tuple(found):
            for simple in tuple(found):
                ahead = found.index(model) < found.index(simple)
                if name(simple) not in contains(model) or not ahead:
                    continue
                if not self.is_distinguished(score(model), score(simple)):
                    found.remove(model)
                    found.insert(found.index(simple) + 1, model)
        return found
