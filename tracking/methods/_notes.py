"""Notes on a track of footage: which part was measured, and which frames are left out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from servosight.tracking.core import Candidate, Track


def with_choice(track: Track, candidates: Sequence[Candidate], pick: int) -> Track:
    """A track of the part at place ``pick`` among the candidates, with what is to be said of that
    choice."""
    notes = ["part and background as one model: for footage in which no textured part is found"]
    if not track.channel.luma:
        notes.append(
            "the grey of the pictures shows no part that the frames confirm: measured in their "
            f"{track.channel.words}, which cameras and codecs hold at half of the size"
        )
    others = [number for number in range(1, len(candidates) + 1) if number != pick]
    if others:
        (x, y), explained = candidates[others[0] - 1].pivot_px, candidates[others[0] - 1].explained
        notes.append(
            f"the part about {x:.0f},{y:.0f} px may be meant as well: it explains "
            f"{explained:.0%} of what changes, the one measured "
            f"{candidates[pick - 1].explained:.0%}; --pick {others[0]} takes it"
        )
    return replace(track, candidates=tuple(candidates), notes=(*notes, *track.notes))


def left_out(track: Track, first: int, last: int, lost: bool) -> tuple[str, ...]:
    """Notes on what is left out of a track: what lies outside of the frames ``first`` to ``last``,
    and, if some is ``lost``, frames in which a part that repeats cannot be followed."""
    notes: list[str] = []
    last = min(last, track.frames - 1)
    if first > 0 or last < track.frames - 1:
        notes.append(
            f"measured from {track.time_s[first]:.2f} to {track.time_s[last]:.2f} s, where the "
            "camera stays in place; the rest is left out"
        )
    if lost:
        first, last = np.flatnonzero(track.found)[[0, -1]].tolist()
        notes.append(
            "the part looks the same at several angles: its angle is unambiguous only from "
            f"{track.time_s[first]:.2f} to {track.time_s[last]:.2f} s; the rest is left out"
        )
    return tuple(notes)
