"""A finding: one sentence on the error of a model, with its size; and what a test works on."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from servosight.diagnose.residuals._judged import Judged
from servosight.diagnose.residuals._samples import Samples, all_samples, held_out_samples
from servosight.models.core import Recording, rms, rounded, spoken, with_article


@dataclass(frozen=True, kw_only=True)
class Finding:
    """What a test shows.

    ``size_deg`` is the rms of the part of the error that it speaks of, ``share`` that part of the
    squared error, ``p`` how often chance shows as much.
    """

    test: str
    sentence: str
    size_deg: float
    share: float
    p: float


@dataclass(frozen=True)
class Case:
    """An error under test, and what it is held to.

    ``samples`` are all samples of the recordings with something held out: a fit can hide what an
    error depends on, not make it up. ``held_out`` are the test samples, and the validation
    samples too where those are too few.
    """

    samples: tuple[Samples, ...]
    held_out: tuple[Samples, ...]
    rms_deg: float
    noise_deg: float
    floor_deg: float

    @classmethod
    def of(cls, judged: Sequence[Judged], floor_deg: float, noise_deg: float) -> Case:
        """The case of a model's errors."""
        samples = tuple(all_samples(judged))
        errors = [one.error_deg for one in samples] or [np.zeros(1)]
        rms_deg = rms(np.concatenate(errors))
        return cls(samples, tuple(held_out_samples(judged)), rms_deg, noise_deg, floor_deg)

    @property
    def judged(self) -> list[Judged]:
        """The recordings under test."""
        return [one.judged for one in self.samples]

    def share_of(self, recording: Recording, square_deg2: float) -> float:
        """Share of the whole squared error, for a mean square over one recording."""
        every = sum(one.time_s.size for one in self.samples)
        part = square_deg2 * recording.time_s.size / every
        return float(np.clip(part / max(self.rms_deg**2, 1e-300), 0.0, 1.0))

    def on(self, recording: Recording) -> str:
        """Which recording a sentence speaks of, where there are several."""
        return f"On {recording.name}: " if len(self.samples) > 1 else ""

    def finding(self, test: str, sentence: str, share: float, p: float) -> Finding:
        """A finding on so large a share of the squared error."""
        size = self.rms_deg * float(np.sqrt(share))
        return Finding(test=test, sentence=sentence, size_deg=size, share=share, p=p)


Test = Callable[[Case], Iterator[Finding]]


def shown(value: float, digits: int = 2) -> str:
    """A number as sentences give it: no exponent, also where it is large."""
    return rounded(float(value), digits).replace("−", "-")


def signed(value: float) -> str:
    """Two digits with the sign in any case.

    >>> signed(0.3), signed(-123.4)
    ('+0.30', '-120')
    """
    return f"{'+' if value >= 0.0 else ''}{shown(value)}"


def listed(effects: Sequence[str]) -> str:
    """Effects as labels: ``a``, ``a and b`` or ``a, b and c``, with spaces for underscores.

    >>> listed(["dead_zone", "backlash"])
    'dead zone and backlash'
    """
    return _joined([spoken(effect) for effect in effects])


def phrased(effects: Sequence[str]) -> str:
    """The same within a sentence, with articles.

    >>> phrased(["dead_zone", "backlash"])
    'a dead zone and backlash'
    """
    return _joined([with_article(effect) for effect in effects])


def _joined(words: Sequence[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
