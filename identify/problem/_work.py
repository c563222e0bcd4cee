"""What simulations were made: how many, at what cost, and what the last of them gave."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array

ORDINARY_STEP_S = 1e-3
"""The steps [s] of the linear core in a simulation that costs 1; those of the whole equation, which
cost ``FULL_STEP`` times as much, may be as much longer."""
MOST_BYTES = 2**26
"""Of the answers that are kept: 3,500 of a recording of 20 s at 120 Hz."""

Key = tuple[Hashable, bytes]
Answer = tuple[Array, int | None]
"""Angles (samples,) of one row, and what they cost, in steps of the linear core."""


@dataclass
class Work:
    """How many simulations of one recording were asked for, and their cost: the same on every
    machine, unlike time.

    The cost is in simulations with a step every ``ORDINARY_STEP_S``: one of a fast motor with a
    kink in its torque costs thirty times as much as one of the linear model. Descents, starts and
    sketches come by the same rows again: what is still kept of these is not simulated again, though
    it counts, so that a budget ends a search at the same place whatever is kept. Answers take
    ``most_bytes`` of memory.
    """

    simulations: int = 0
    cost: float = 0.0
    most_bytes: int = MOST_BYTES
    _kept: OrderedDict[Key, Answer] = field(default_factory=OrderedDict, repr=False, compare=False)
    _bytes: int = field(default=0, repr=False, compare=False)

    @property
    def spent(self) -> tuple[int, float]:
        """The number of simulations and their cost so far."""
        return self.simulations, self.cost

    def relative_cost(self, before: tuple[int, float]) -> float:
        """The cost of a simulation since ``before`` over that of one until then; 1 where there is
        none.

        >>> work = Work(simulations=100, cost=200.0)
        >>> before = work.spent
        >>> work.simulations, work.cost = 102, 220.0
        >>> work.relative_cost(before)
        5.0
        """
        count, cost = before
        later = self.simulations - count
        if not (count and later and cost > 0.0):
            return 1.0
        return (self.cost - cost) / later / (cost / count)

    def angles(
        self,
        asked: Hashable,
        rows: Array,
        duration_s: float,
        simulate: Callable[[Array], tuple[Array, NDArray[np.int64] | None]],
    ) -> Array:
        """Angles (batch, samples) of ``rows`` (batch, parameters): each different row once.

        ``asked`` stands for the plant and all that it is given beside the rows, and ``duration_s``
        for how long that lasts. ``simulate`` returns angles and what each row cost.
        """
        keys = [(asked, row.tobytes()) for row in rows]
        places = dict(zip(keys, range(len(keys)), strict=True))
        answers = {key: self._kept[key] for key in places if key in self._kept}
        lacking = [key for key in places if key not in answers]
        if lacking:
            found, steps = simulate(rows[[places[key] for key in lacking]])
            taken = [None] * len(lacking) if steps is None else steps.tolist()
            answers |= zip(lacking, zip(found, taken, strict=True), strict=True)
        self._count(answers, duration_s)
        self._keep(answers)
        return np.array([answers[key][0] for key in keys])

    def _count(self, answers: dict[Key, Answer], duration_s: float) -> None:
        steps = [taken for _, taken in answers.values()]
        self.simulations += len(steps)
        known = [taken for taken in steps if taken is not None]
        self.cost += len(steps) - len(known) + sum(known) * ORDINARY_STEP_S / duration_s

    def _keep(self, answers: dict[Key, Answer]) -> None:
        """The last answers that fit into the memory, the latest last."""
        for key, (angles, taken) in answers.items():
            if key in self._kept:
                self._kept.move_to_end(key)
            else:
                self._kept[key] = angles.copy(), taken  # a view would hold its whole batch
                self._bytes += angles.nbytes
        while self._bytes > self.most_bytes:
            self._bytes -= self._kept.popitem(last=False)[1][0].nbytes
