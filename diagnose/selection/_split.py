"""Fit, validation and test: which samples the parameters, the selection and the report see."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from servosight.diagnose.residuals import FIT, TEST, VALIDATION, Uses
from servosight.diagnose.selection._beyond import beyond_fitted
from servosight.identify.fit import CommandFrames, in_frames
from servosight.models.core import Mask, Recording

BLOCK_S = 1.0
HELD_OUT_EVERY = 3
"""Every third block is held out; of these, every second one is for the test."""
SHORTEST_TEST_S = 0.5
"""Less time than this makes no test."""


@dataclass(frozen=True)
class Split:
    """Recordings and the uses of their samples, fitted recordings first.

    ``recordings`` have samples to fit on, ``carried`` samples to validate on and none to fit on,
    ``tested`` are for the test alone. ``uses`` and ``carried_uses`` (samples,) each. ``late_s`` is
    by how much the angles of the fitted recordings, then of the carried ones, were taken as earlier
    than their stamps, ``frames`` are the instants at which their commands act, where not at each of
    their rows.
    """

    recordings: tuple[Recording, ...]
    uses: tuple[Uses, ...]
    carried: tuple[Recording, ...] = ()
    carried_uses: tuple[Uses, ...] = ()
    tested: tuple[Recording, ...] = ()
    warnings: tuple[str, ...] = ()
    late_s: tuple[float, ...] = ()
    frames: tuple[CommandFrames | None, ...] = ()

    @classmethod
    def of(
        cls,
        recordings: Sequence[Recording],
        validate: Sequence[Recording] = (),
        test: Sequence[Recording] = (),
        choice: int = 0,
    ) -> Split:
        """Divide recordings as docs/diagnosis.md says.

        ``choice`` takes another of the thirds that may be held out, best first. A recording too
        short for a test has none, with a warning.
        """
        apart = not test
        if validate:
            uses = [np.full(one.time_s.size, FIT, dtype=np.int8) for one in recordings]
            carried = [_alternating(one) if apart else _all(one, VALIDATION) for one in validate]
            divided = list(zip(validate, carried, strict=True))
        else:
            uses = [_blocks(one, choice, apart) for one in recordings]
            carried = []
            divided = list(zip(recordings, uses, strict=True))
        short = [one.name for one, use in divided if apart and not np.any(use == TEST)]
        reported = _reported([use for _, use in divided])
        return cls(
            tuple(recordings),
            tuple(uses),
            tuple(validate),
            tuple(carried),
            tuple(test),
            tuple(_too_short(name, reported) for name in short),
            (0.0,) * (len(recordings) + len(validate)),
            (None,) * (len(recordings) + len(validate)),
        )

    def earlier(self, late_s: Sequence[float]) -> Split:
        """The same uses of the same samples, with the angles earlier by ``late_s``."""
        count = len(self.recordings)
        return replace(
            self,
            recordings=_earlier(self.recordings, late_s[:count]),
            carried=_earlier(self.carried, late_s[count:]),
            late_s=tuple(a + b for a, b in zip(self.late_s, late_s, strict=True)),
        )

    def in_frames(self, frames: Sequence[CommandFrames | None]) -> Split:
        """The same uses of the same samples, with commands that act once a frame where they do."""
        count = len(self.recordings)
        return replace(
            self,
            recordings=in_frames(self.recordings, frames[:count]),
            carried=in_frames(self.carried, frames[count:]),
            frames=tuple(frames),
        )

    @cached_property
    def carried_beyond(self) -> tuple[Mask, ...]:
        """Of each carried recording, the samples that do not choose, as nothing fitted is alike."""
        return beyond_fitted(self.recordings, self.masks, self.carried, self.carried_uses)

    @property
    def mean_s(self) -> float:
        """How long the fitted recordings last in the mean [s]."""
        return float(np.mean([one.time_s[-1] - one.time_s[0] for one in self.recordings]))

    @property
    def masks(self) -> tuple[Mask, ...]:
        """For each fitted recording, the samples to fit on."""
        return tuple(np.asarray(use == FIT) for use in self.uses)

    @property
    def untested(self) -> tuple[Mask, ...]:
        """For each fitted recording, the samples that are not for the test."""
        return tuple(np.asarray(use != TEST) for use in self.uses)


def _earlier(recordings: Sequence[Recording], late_s: Sequence[float]) -> tuple[Recording, ...]:
    return tuple(one.shifted(-late) for one, late in zip(recordings, late_s, strict=True))


def _too_short(name: str, reported: str) -> str:
    return (
        f"{name}: too short to be split into fit, validation and test blocks of one second; the "
        f"reported error is {reported}"
    )


def _reported(uses: Sequence[Uses]) -> str:
    """Which data the error is of where a recording has no test: what ``held_out_rms`` is over."""
    given = {int(use) for one in uses for use in np.unique(one)}
    if TEST in given:
        return "that of the test data of the other recordings"
    if VALIDATION in given:
        return "the validation error, of the data that chose the effects"
    return "the error of the fitted data, which chose the effects as well"


def _all(recording: Recording, use: int) -> Uses:
    return np.full(recording.time_s.size, use, dtype=np.int8)


def _numbers(recording: Recording) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """The number of each sample's block of one second, (samples,)."""
    since = recording.time_s - recording.time_s[0]
    return np.asarray(np.floor(since / BLOCK_S).astype(np.int64))


def _alternating(recording: Recording) -> Uses:
    """Blocks for validation and for the test in turn, beginning with validation."""
    odd = _numbers(recording) % 2 == 1
    return _with_test(recording, ~odd, odd)


def _blocks(recording: Recording, choice: int, apart: bool) -> Uses:
    """Of every six blocks four to fit on, one to validate on and, if ``apart``, one to test on.

    Which ones is decided by the motion alone: the first choice is that without whose held-out
    samples the fitted ones lose least of the range, so that a model is judged within what it has
    seen. The first block is always fitted: without it the initial state is not determined.
    """
    number = _numbers(recording)
    found = []
    for first in reversed(range(1, HELD_OUT_EVERY)):
        held = number % HELD_OUT_EVERY == first
        odd = (number // HELD_OUT_EVERY) % 2 == 1
        if apart:
            found.append(_with_test(recording, held & ~odd, held & odd))
        else:
            found.append(_with_test(recording, held, np.zeros_like(held)))
    long = [uses for uses in found if _lasts_s(recording, uses != FIT) >= SHORTEST_TEST_S]
    usable = long or [uses for uses in found if np.any(uses != FIT)] or found[:1]
    tested = [uses for uses in usable if np.any(uses == TEST)] or usable
    ranked = sorted(tested, key=lambda uses: _unseen(recording, uses == FIT))
    return ranked[min(choice, len(ranked) - 1)]


def _with_test(recording: Recording, validation: Mask, test: Mask) -> Uses:
    """Uses of the samples; where the test would be too short it validates as well."""
    uses = np.full(recording.time_s.size, FIT, dtype=np.int8)
    uses[validation] = VALIDATION
    uses[test] = TEST if _lasts_s(recording, test) >= SHORTEST_TEST_S else VALIDATION
    return uses


def _lasts_s(recording: Recording, some: Mask) -> float:
    """How long some of the samples (samples,) last together [s]."""
    return float(some.sum() * np.median(np.diff(recording.time_s)))


def _unseen(recording: Recording, fitted: Mask) -> float:
    """How far angle, speed and acceleration go beyond those of the fitted samples."""
    speed = np.gradient(recording.angle_deg, recording.time_s)
    away = recording.angle_deg - np.median(recording.angle_deg)
    motion = np.abs(np.stack([away, speed, np.gradient(speed, recording.time_s)]))
    largest = motion.max(axis=1)
    return float(np.sum(1.0 - motion[:, fitted].max(axis=1) / np.maximum(largest, 1e-12)))
