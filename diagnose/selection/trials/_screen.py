"""A first look at what each effect could take off a model's error, before any of them is fitted."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from servosight.identify.fit import Solution, initial_changes
from servosight.identify.problem import Problem, Work, score_directions
from servosight.models.core import Array


@dataclass(frozen=True)
class Screen:
    """Changes of the prediction that effects would make, seen from a fitted model.

    ``names`` (changes,) says whose change each row is, ``gains`` (changes,) by how much it would
    lower the residual's sum of squares if it were scaled at will and the model's own parameters
    followed, and ``pair_gains`` (changes, changes) the same for two of them together. First order
    only: it orders what to fit, and decides nothing.
    """

    names: tuple[str, ...]
    gains: Array
    pair_gains: Array

    @classmethod
    def of(cls, names: tuple[str, ...], changes: Array, residual: Array, jacobian: Array) -> Screen:
        """From the residual (samples,), its Jacobian (samples, parameters) and the changes.

        ``changes`` (changes, samples) are the residual with an effect at one of its starting points
        minus the residual without it.
        """
        unit, agree = score_directions(changes, residual, jacobian)
        return cls(names, np.maximum(agree, 0.0) ** 2, _pair_gains(agree, unit @ unit.T))

    @classmethod
    def behind(cls, fit: Solution, names: Sequence[str], problems: Sequence[Problem]) -> Screen:
        """What each of ``names`` would change in the error of ``fit``.

        ``problems`` are the fits that have it. An effect with a ``least_share`` is left out where
        it promises less of the squared error, or another one more. To look at that does not
        shorten the search.
        """
        known = {one.id: one.least_share for p in problems for one in p.plant.layout.effects}
        changes = [
            initial_changes(replace(problem, work=Work()) if known[name] else problem, fit)
            for name, problem in zip(names, problems, strict=True)
        ]
        owners = [name for name, own in zip(names, changes, strict=True) for _ in own]
        joined = np.concatenate([np.empty((0, fit.residual.size)), *changes])
        found = cls.of(tuple(owners), joined, fit.residual, fit.jacobian)
        squares, most = float(fit.residual @ fit.residual), float(found.gains.max(initial=0.0))
        asked = [name for name in names if known[name]]
        return found.promising({name: max(known[name] * squares, most) for name in asked})

    @property
    def _promise(self) -> dict[str, float]:
        """What each effect gains at most."""
        found: dict[str, float] = {}
        for name, gain in zip(self.names, self.gains, strict=True):
            found[name] = max(found.get(name, 0.0), float(gain))
        return found

    def promising(self, least: Mapping[str, float]) -> Screen:
        """Without the effects that promise less than the ``least`` gain of their name."""
        promise = self._promise
        kept = [i for i, name in enumerate(self.names) if promise[name] >= least.get(name, 0.0)]
        names = tuple(self.names[i] for i in kept)
        return Screen(names, self.gains[kept], self.pair_gains[np.ix_(kept, kept)])

    def best(self, count: int) -> list[str]:
        """The effects that promise most, best first."""
        promise = self._promise
        return sorted(promise, key=lambda name: -promise[name])[:count]

    def best_pairs(self, count: int, among: Collection[str]) -> list[tuple[str, str]]:
        """The pairs of different effects ``among`` some that promise most, best first."""
        owner = np.array(self.names)
        able = np.isin(owner, list(among))
        apart = (owner[:, None] != owner) & able[:, None] & able
        gains = np.where(apart, self.pair_gains, -1.0)
        found: list[tuple[str, str]] = []
        for index in np.argsort(-gains, axis=None):
            i, j = divmod(int(index), len(owner))
            if len(found) == count or gains[i, j] < 0.0:
                break
            pair = (self.names[i], self.names[j])
            if pair not in found and pair[::-1] not in found:
                found.append(pair)
        return found


def _pair_gains(agree: Array, alike: Array) -> Array:
    """Least squares on two unit vectors with non-negative factors, for every pair."""
    alone = np.maximum(agree, 0.0) ** 2
    rest = np.maximum(1.0 - alike**2, 1e-9)
    first = (agree[:, None] - alike * agree) / rest
    second = first.T
    joint = first * agree[:, None] + second * agree
    inside = (first > 0.0) & (second > 0.0) & (np.abs(alike) < 1.0 - 1e-6)
    return np.asarray(np.where(inside, joint, np.maximum(alone[:, None], alone)))
