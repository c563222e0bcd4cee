"""When goals take effect behind a device that sends a pulse at an even rate of its own.

A hobby servo hears nothing between two pulses. A goal that reaches the device therefore waits for
the next pulse, by up to a period (20 ms), and since the two clocks differ by some 1e-4 the wait
changes over a run. Asking the device which pulse it sends gives pairs of host times between which a
pulse began; all pairs together leave little room for the train of pulses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from servosight.bench.servo._protocol import Sent
from servosight.models.core import Array

_LEAST = 8
"""Pulses that must have been seen; with less the train is not known."""
_LARGEST_DRIFT = 5e-3
_ROUNDS = 4


@dataclass(frozen=True, kw_only=True)
class PulseTrain:
    """Pulses at ``start_s + n period_s`` by the host's clock, the start with ``sigma_s``."""

    start_s: float
    period_s: float
    sigma_s: float

    def taken(self, sent: Sequence[Sent]) -> list[Sent]:
        """Goals at the pulses with which they take effect; of several before one pulse, the last.

        >>> train = PulseTrain(start_s=0.0, period_s=0.02, sigma_s=0.0)
        >>> [one.time_s for one in train.taken([Sent(0.031, 1.0), Sent(0.035, 2.0)])]
        [0.04]
        """
        number = [int(np.ceil((one.time_s - self.start_s) / self.period_s)) for one in sent]
        last = {n: one.angle_deg for n, one in zip(number, sent, strict=True)}
        return [Sent(self.start_s + n * self.period_s, angle) for n, angle in last.items()]


def pulse_train(between_s: Sequence[tuple[float, float]], period_s: float) -> PulseTrain | None:
    """The train of pulses of which one began within each pair of times; None with too few pairs.

    ``period_s`` is the nominal period. The pulses are numbered by it, a line through the pairs'
    middles gives the period, and the pairs themselves bound the start: the standard deviation is
    that of an even distribution over what they leave, or over a pair where they leave nothing.

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
    first, last = _room(low, high, number * period)
    if last <= first:  # an exchange was interrupted: the pairs contradict each other
        return PulseTrain(
            start_s=start, period_s=period, sigma_s=float(np.median(high - low)) / np.sqrt(12.0)
        )
    return PulseTrain(
        start_s=0.5 * (first + last), period_s=period, sigma_s=(last - first) / np.sqrt(12.0)
    )


def _room(low: Array, high: Array, at: Array) -> tuple[float, float]:
    return float((low - at).max()), float((high - at).min())
