"""When goals take effect behind a device that sends a pulse at an even rate of its own.

A hobby servo receives nothing between two pulses. A goal that reaches the device therefore waits
for the next pulse, by up to a period (20 ms), and since the two clocks differ by some 1e-4 the wait
changes over a run. Asking the device which pulse it sends gives pairs of host times between which a
pulse began; all pairs together leave little room for the train of pulses. Which goal a pulse had is
a question of its own where goals come near a pulse, as they do for long where rows are as even as
pulses: what the device answered within that pulse decides it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from servosight.bench.servo._protocol import Sent
from servosight.models.core import Array

_LEAST = 8
"""Pulses that must have been seen; with less the train is not known."""
_LARGEST_DRIFT = 5e-3
_ROUNDS = 4
_ORDER_S = 1e-3
"""An order this near to a pulse may have come before or after it: an adapter takes orders once in a
millisecond."""
_SIGMAS = 4.0


class Shown(NamedTuple):
    """An answer: between two host times the device sent the pulse of this goal [s, s, deg]."""

    asked_s: float
    answered_s: float
    angle_deg: float


@dataclass(frozen=True, kw_only=True)
class PulseTrain:
    """Pulses at ``start_s + n period_s`` by the host's clock, the start with ``sigma_s``."""

    start_s: float
    period_s: float
    sigma_s: float

    def taken(self, sent: Sequence[Sent], shown: Sequence[Shown] = ()) -> tuple[list[Sent], float]:
        """Goals at the pulses with which they take effect; of several before one pulse, the last.

        Also the standard deviation of these times [s]: of the train, and of the goals of which
        neither their time nor an answer in ``shown`` says before which pulse they came.

        >>> train = PulseTrain(start_s=0.0, period_s=0.02, sigma_s=0.0)
        >>> goals, sigma_s = train.taken([Sent(0.031, 1.0), Sent(0.035, 2.0)])
        >>> [one.time_s for one in goals], sigma_s
        ([0.04], 0.0)
        >>> near = [Sent(0.031, 1.0), Sent(0.0599, 2.0)]
        >>> [one.time_s for one in train.taken(near, [Shown(0.062, 0.063, 1.0)])[0]]
        [0.04, 0.08]
        """
        asked = [one.asked_s for one in shown]
        cuts = [*np.searchsorted(asked, [one.time_s for one in sent]).tolist(), len(shown)]
        bounds = [
            self._bounds(one, sent[max(k - 1, 0)], shown[cuts[k] : cuts[k + 1]])
            for k, one in enumerate(sent)
        ]
        open_ = [low != high for low, high in bounds]
        chosen = [
            self._next(one.time_s) if wide else low
            for one, wide, (low, _) in zip(sent, open_, bounds, strict=True)
        ]
        number = np.maximum.accumulate(chosen).tolist()
        last = {n: one.angle_deg for n, one in zip(number, sent, strict=True)}
        goals = [Sent(self.start_s + n * self.period_s, angle) for n, angle in last.items()]
        # An undecided goal is right, or a period off, and its neighbours with it.
        doubt_s = 0.5 * self.period_s * sum(open_) / len(sent)
        return goals, float(np.hypot(self.sigma_s, doubt_s))

    def _next(self, time_s: float) -> int:
        """The number of the first pulse from a time on."""
        return int(np.ceil((time_s - self.start_s) / self.period_s))

    def _bounds(self, goal: Sent, before: Sent, answers: Sequence[Shown]) -> tuple[int, int]:
        """The first and the last pulse with which a goal may take effect, after ``answers``."""
        if goal.angle_deg == before.angle_deg:
            return (self._next(goal.time_s),) * 2
        slack_s = _SIGMAS * self.sigma_s
        low = self._next(goal.time_s - _ORDER_S - slack_s)
        high = self._next(goal.time_s + _ORDER_S + slack_s)
        for one in answers:
            if one.angle_deg == goal.angle_deg:
                high = min(high, self._next(one.answered_s + slack_s) - 1)
            elif one.angle_deg == before.angle_deg:
                low = max(low, self._next(one.asked_s - slack_s))
        return low, high


def pulse_train(between_s: Sequence[tuple[float, float]], period_s: float) -> PulseTrain | None:
    """The train of pulses of which one began within each pair of times; None with too few pairs.

    ``period_s`` is the nominal period, by which the pulses are numbered. Every pair bounds its
    pulse: of the even trains that keep all bounds, the one halfway between the earliest and the
    latest in the middle of the run is taken, and the standard deviation is that of an even
    distribution between these two. Where pairs contradict each other, it is a line through their
    middles, and the median pair is the room.

    >>> begun = 0.003 + 0.02001 * np.arange(50)
    >>> train = pulse_train([(one - 0.0004, one + 0.0009) for one in begun.tolist()], 0.02)
    >>> train is not None and bool(abs(train.start_s - 0.003) < 0.001)
    True
    """
    if len(between_s) < _LEAST:
        return None
    low, high = (np.array(side) for side in zip(*between_s, strict=True))
    middle = 0.5 * (low + high)
    number, period, start = np.zeros(middle.size), period_s, float(middle[0])
    for _ in range(_ROUNDS):
        # Counted along the way: an error of the period would add up over a long run.
        number = np.concatenate([[0.0], np.cumsum(np.rint(np.diff(middle) / period))])
        period, start = (float(one) for one in np.polyfit(number, middle - middle[0], 1))
        start += float(middle[0])
    if abs(period / period_s - 1.0) > _LARGEST_DRIFT:
        return None
    line, along = start + period * number, number / number[-1] - 0.5
    least, most = (_extreme(sign, along, low - line, high - line) for sign in (1.0, -1.0))
    if least is None or most is None:  # an exchange was interrupted
        return PulseTrain(
            start_s=start, period_s=period, sigma_s=float(np.median(high - low)) / np.sqrt(12.0)
        )
    shift, turn = 0.5 * (least + most)
    return PulseTrain(
        start_s=start + float(shift - 0.5 * turn),
        period_s=period + float(turn / number[-1]),
        sigma_s=float(most[0] - least[0]) / np.sqrt(12.0),
    )


def _extreme(sign: float, along: Array, low: Array, high: Array) -> Array | None:
    """The earliest or the latest train within bounds: its shift and turn [s], None without one.

    ``along`` is -0.5 at the first pulse of the run and 0.5 at the last, (pulses,) each.
    """
    from scipy.optimize import linprog

    lines = np.column_stack([np.ones(along.size), along])
    bounds_ms = 1e3 * np.concatenate([high, -low])  # the solver's tolerances are for numbers near 1
    free = [(None, None)] * 2
    done = linprog([sign, 0.0], np.vstack([lines, -lines]), bounds_ms, bounds=free, method="highs")
    return 1e-3 * np.asarray(done.x) if done.success else None
