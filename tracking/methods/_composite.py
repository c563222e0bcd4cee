"""Part and background as one model, for footage as people film it: where ``refine`` finds nothing.

No features, no texture and no camera at rest are needed; less exact, some hundredths of a degree.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from servosight.models.core import FrameProgress, Mask
from servosight.tracking.composite import FoundPart
from servosight.tracking.core import Candidate, Track, TrackOptions, TrackRefused
from servosight.tracking.methods._closer import measured_closer
from servosight.tracking.methods._footage import Footage
from servosight.tracking.video import Film


def composite(film: Film, options: TrackOptions, progress: FrameProgress | None = None) -> Track:
    """The angle of the part that explains most of what changes while the camera rests.

    With hints, of the part that these point at. Where nothing is pointed at, and the frames do not
    confirm a part in grey, it is looked for in colour. ``TrackRefused``, as in grey unless a part
    was measured in colour alone, where there is none, or the frames do not confirm it.
    """
    footage = Footage.of(film, options)
    try:
        return _in_one_channel(footage, progress)
    except TrackRefused as refused:
        coloured = None if options.pointed else footage.in_colour()
        if coloured is None:
            raise
        try:
            return _in_one_channel(coloured, progress)
        except TrackRefused as again:
            in_colour_alone = again.uncertain and not refused.measured
            raise (again if in_colour_alone else refused) from None


def _in_one_channel(footage: Footage, progress: FrameProgress | None) -> Track:
    """The track of the part that explains most of the change in the channel of the footage."""
    number = footage.options.pick
    parts = footage.parts()
    if number > len(parts):
        parts += footage.parts(parts)
    try:
        track, inside = footage.measured(footage.chosen(parts), progress)
    except TrackRefused as refused:
        small = refused.uncertain
        closer = measured_closer(footage, parts[number - 1], progress) if small else None
        if closer is None:
            track, inside, number = _otherwise(footage, parts, refused, progress)
        else:
            track, inside = closer
    candidates: tuple[Candidate, ...] = ()
    if track.channel.luma:  # in which --pick counts
        candidates = tuple(footage.candidate(part) for part in parts)
    notes = _notes(track, candidates, number, inside)
    return replace(track, candidates=candidates, notes=(*notes, *track.notes))


def _otherwise(
    footage: Footage, parts: list[FoundPart], refused: TrackRefused, progress: FrameProgress | None
) -> tuple[Track, Mask, int]:
    """The track of a part that is tried instead of one that was refused, the frames in which it was
    looked for, and its number; the parts that are found are added to ``parts``."""
    # An uncertain angle of a part in full view is no reason to measure what enters instead.
    if footage.options.pick > 1 or not parts or (refused.measured and parts[0].inside):
        raise refused
    # In grey these were tried: what stands out in colour no better is someone at the side.
    if not footage.stabilised.channel.luma:
        raise refused
    tried = len(parts) if refused.measured else 1
    parts += footage.parts(parts)
    return footage.instead(parts, tried, refused, progress)


def _notes(
    track: Track, candidates: Sequence[Candidate], pick: int, inside: Mask
) -> tuple[str, ...]:
    """What was measured, which other part may be meant as well, and what is left out."""
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
    if not inside.all():
        first, last = np.flatnonzero(inside)[[0, -1]]
        notes.append(
            f"measured from {track.time_s[first]:.2f} to {track.time_s[last]:.2f} s, where the "
            "camera stays in place; the rest is left out"
        )
    return tuple(notes)
