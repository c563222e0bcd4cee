"""What a diagnosis used each recording for: from the split of its samples, and back to it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from servosight.diagnose.residuals import FIT, TEST, VALIDATION, Uses
from servosight.diagnose.selection import Spans, Split
from servosight.identify.fit import CommandFrames
from servosight.models.core import Mask, Recording, Table, runs_of


@dataclass(frozen=True, kw_only=True)
class RecordingUse:
    """A recording of the diagnosis and the times [s] of its held-out samples.

    ``role`` is "fit", "validation" or "test" where all samples are for that, else "split";
    ``validation_s`` and ``test_s`` list first and last sample of each stretch. ``stretches_s``
    lists the stretches of a long recording that alone were simulated, each with a bias and an
    initial state of its own; it is empty where the recording was used whole. ``latency_s`` is by
    how much its angles were taken as earlier than their stamps, since they lag those of the others:
    the times of its held-out samples are those. Where its command was taken to act once a frame,
    ``command_frame_s`` is a frame's length and ``command_frame_at_s`` the time of one; else both
    are 0.
    """

    name: str
    role: str
    path: Path | None
    validation_s: tuple[tuple[float, float], ...]
    test_s: tuple[tuple[float, float], ...]
    stretches_s: Spans = ()
    latency_s: float = 0.0
    command_frame_s: float = 0.0
    command_frame_at_s: float = 0.0

    def seen(self, recording: Recording) -> Recording:
        """The recording as the models saw it: earlier, and in frames, where it was taken so."""
        recording = recording.shifted(-self.latency_s)
        if not self.command_frame_s:
            return recording
        return recording.in_frames(self.command_frame_s, self.command_frame_at_s)

    @property
    def parts(self) -> tuple[str, ...]:
        """What the parts that were simulated are called: its name, with the time of a stretch."""
        spans = (f"{self.name}, {start:.0f} to {end:.0f} s" for start, end in self.stretches_s)
        return tuple(spans) or (self.name,)

    def uses(self, recording: Recording) -> Uses:
        """The uses of the samples of the recording, or of a part of it, (samples,)."""
        whole = {"validation": VALIDATION, "test": TEST}.get(self.role, FIT)
        uses = np.full(recording.time_s.size, whole, dtype=np.int8)
        for kind, stretches in ((VALIDATION, self.validation_s), (TEST, self.test_s)):
            for start, end in stretches:
                uses[(recording.time_s >= start) & (recording.time_s <= end)] = kind
        return uses


def recording_uses(split: Split, spans: Sequence[Spans]) -> Table[RecordingUse]:
    """What each recording was used for; ``spans`` are the stretches of each."""
    tested = [np.full(one.time_s.size, TEST, dtype=np.int8) for one in split.tested]
    recordings = (*split.recordings, *split.carried, *split.tested)
    uses = (*split.uses, *split.carried_uses, *tested)
    late_s = (*split.late_s, *(0.0 for _ in split.tested))
    frames = (*split.frames, *(None for _ in split.tested))
    parts = iter(zip(recordings, uses, late_s, frames, strict=True))
    return Table(_use([next(parts) for _ in own or [()]], own) for own in spans)


def _use(
    parts: Sequence[tuple[Recording, Uses, float, CommandFrames | None]], spans: Spans
) -> RecordingUse:
    roles = {FIT: "fit", VALIDATION: "validation", TEST: "test"}
    single = np.unique(np.concatenate([uses for _, uses, *_ in parts]))
    first, _, late_s, frames = parts[0]
    return RecordingUse(
        name=first.name,
        role=roles[int(single[0])] if single.size == 1 else "split",
        path=first.path,
        validation_s=tuple(x for one, uses, *_ in parts for x in _times(one, uses == VALIDATION)),
        test_s=tuple(x for one, uses, *_ in parts for x in _times(one, uses == TEST)),
        stretches_s=spans,
        latency_s=late_s,
        command_frame_s=0.0 if frames is None else frames.period_s,
        command_frame_at_s=0.0 if frames is None else frames.at_s,
    )


def _times(recording: Recording, mask: Mask) -> Iterator[tuple[float, float]]:
    """First and last time of each run of samples under the mask."""
    times = recording.time_s
    for i, j in runs_of(mask):
        yield float(times[i]), float(times[j - 1])
