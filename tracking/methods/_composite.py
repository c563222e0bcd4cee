"""Part and background as one model, for footage as people film it: where ``refine`` finds nothing.

No features, no texture and no camera at rest are needed; less exact, some hundredths of a degree.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from servosight.models.core import FrameProgress
from servosight.tracking.composite import CLICKED, TRUST, FoundPart, uncertain
from servosight.tracking.core import Track, TrackOptions, TrackRefused
from servosight.tracking.methods._closer import measured_closer
from servosight.tracking.methods._compared import alike, beside, surest
from servosight.tracking.methods._footage import Footage
from servosight.tracking.methods._notes import with_choice
from servosight.tracking.methods._places import measured_in_places
from servosight.tracking.video import Film

Measure = Callable[[Footage, FoundPart, FrameProgress | None], Track]
_RIVALS = 2  # parts that are tried where the frames refuse the first one


def composite(film: Film, options: TrackOptions, progress: FrameProgress | None = None) -> Track:
    """The angle of the part that explains most of what changes while the camera rests.

    With hints, of the part that these point at. Where the frames do not confirm a part in grey, its
    shadow is taken out of them, and where nothing is pointed at it is looked for in colour. Where
    nothing better is found, the surest of the uncertain angles of one part is returned, with a
    note. ``TrackRefused``, as in grey unless a part was measured otherwise alone, where there is
    none, or the frames do not confirm it.

    A pivot alone that leads to no angle, or to an uncertain one, is to be no worse than none: what
    is found without it is taken if it turns about that place and is surer.
    """
    try:
        track = _as_given(film, options, progress)
    except TrackRefused:
        other = _without_pivot(film, options, progress)
        if other is None:
            raise
        return other
    if not _uncertain(track):
        return track
    other = _without_pivot(film, options, progress)
    return track if other is None else surest(track, other)


def composite_about(
    film: Film, options: TrackOptions, pivot_px: tuple[float, float],
    progress: FrameProgress | None = None,
) -> Track:  # fmt: skip
    """As ``composite``, of the part that turns about a known pivot and of no other;
    ``TrackRefused`` where none is found there."""
    return _as_given(film, replace(options, pivot=pivot_px), progress)


def _without_pivot(
    film: Film, options: TrackOptions, progress: FrameProgress | None
) -> Track | None:
    """The track that is found without the pivot that is given alone, if it turns about that place;
    None if not, or where more or none is given."""
    pivot = options.pivot
    if pivot is None or options.template is not None or options.tip is not None:
        return None
    try:
        found = _as_given(film, replace(options, pivot=None, at_s=None), progress)
    except TrackRefused:
        return None
    away_px = float(np.hypot(*np.subtract(found.pivot_px, pivot)))
    return found if away_px < CLICKED * max(film.images[0].shape) else None


def _uncertain(track: Track) -> bool:
    """Whether a track's angles are, without the errors that all share, as of the tilt."""
    shared = 0.0 if track.shared_deg is None else (track.shared_deg**2).sum(1)
    own_deg = np.sqrt(np.maximum(track.sigma_deg**2 - shared, 0.0))
    return uncertain(track.angle_deg[track.found], own_deg[track.found]) is not None


def _as_given(film: Film, options: TrackOptions, progress: FrameProgress | None) -> Track:
    """The track of the part that the options point at, or of any that turns."""
    footage = Footage.of(film, options)
    try:
        return _in_one_channel(footage, progress)
    except TrackRefused as in_grey:
        refused = in_grey
    lit = footage.without_shadow() if options.pick == 1 else None
    track, refused = _seen_otherwise(lit, refused, progress)
    if track is not None and (refused.rough is None or alike(refused.rough, track)):
        refused.rough = track if refused.rough is None else surest(track, refused.rough)
        if not _uncertain(refused.rough):
            return refused.rough
    coloured = None if options.pointed else footage.in_colour()
    track, refused = _seen_otherwise(coloured, refused, progress)
    if track is not None:
        return track
    if refused.rough is None:
        raise refused
    return refused.rough


def _seen_otherwise(
    footage: Footage | None, refused: TrackRefused, progress: FrameProgress | None
) -> tuple[Track | None, TrackRefused]:
    """The track in pictures that show the same frames otherwise, if they confirm one, and the more
    telling one of their refusal and that of the frames as they are."""
    if footage is None:
        return None, refused
    try:
        return _in_one_channel(footage.knowing(refused.rough), progress), refused
    except TrackRefused as again:
        return None, more_telling(refused, again)


def _in_one_channel(footage: Footage, progress: FrameProgress | None) -> Track:
    """The track of the part that explains most of the change in the channel of the footage, or in
    a place of it."""
    try:
        return _in_whole(footage, progress)
    except TrackRefused as refused:
        return measured_in_places(footage, refused, progress)


def _in_whole(footage: Footage, progress: FrameProgress | None) -> Track:
    """The track of the part that explains most of the change in whole pictures."""
    number = footage.options.pick
    parts = footage.parts()
    if number > len(parts):
        parts += footage.parts(parts)
    footage.check(parts)
    try:
        return _of_part(footage, parts, number, Footage.measured, progress)
    except TrackRefused as first:
        refused = first
    if refused.uncertain:
        try:
            return _of_part(
                footage.knowing(refused.rough), parts, number, measured_closer, progress
            )
        except TrackRefused as closer:
            refused = surer(refused, closer)
    return _otherwise(footage, parts, refused, progress)


def _of_part(
    footage: Footage, parts: Sequence[FoundPart], number: int, measure: Measure,
    progress: FrameProgress | None,
) -> Track:  # fmt: skip
    """The track of the part at that place, and a rough one, with what is to be said of it."""
    # --pick counts the parts of the pictures as they are.
    as_filmed = not footage.stabilised.coloured
    candidates = [footage.candidate(part) for part in parts] if as_filmed else []
    try:
        return with_choice(measure(footage, parts[number - 1], progress), candidates, number)
    except TrackRefused as refused:
        if refused.rough is not None:
            refused.rough = with_choice(refused.rough, candidates, number)
        raise


def surer(first: TrackRefused, second: TrackRefused) -> TrackRefused:
    """Of two refusals of one part that with the smaller sigma, if the second one has any."""
    if first.rough is None or second.rough is None:
        return first if second.rough is None else second
    return first if surest(first.rough, second.rough) is first.rough else second


def more_telling(refused: TrackRefused, again: TrackRefused) -> TrackRefused:
    """Of a refusal in grey and one in colour that with the smaller sigma, if both have an angle. Of
    two parts that turn beside each other, as two servos do, that in grey is meant as it is first
    found; nothing tells which is where they pass at one place and do not turn alike: then none has
    an angle. Else the second one if it alone has an angle, or its sigma alone refused it."""
    if refused.rough is not None and again.rough is not None:
        if alike(refused.rough, again.rough):
            return surer(refused, again)
        if beside(refused.rough, again.rough):
            return refused
        return TrackRefused(str(refused), refused.draw, measured=True)
    better = again.rough is not None if refused.measured else again.uncertain
    return again if better and refused.rough is None else refused


def _otherwise(
    footage: Footage, parts: list[FoundPart], refused: TrackRefused, progress: FrameProgress | None
) -> Track:
    """The track of the first part that the frames confirm instead of one that was refused; the
    parts that are found are added to ``parts``."""
    # An uncertain angle of a part in full view is no reason to measure what enters instead.
    if footage.options.pick > 1 or not parts or (refused.measured and parts[0].inside):
        raise refused
    # In grey these were tried: what stands out in colour no better is someone at the side.
    if not footage.stabilised.channel.luma:
        raise refused
    tried = len(parts) if refused.measured else 1
    parts += footage.parts(parts)
    return instead(footage, parts, tried, refused, progress)


def instead(
    footage: Footage, parts: Sequence[FoundPart], tried: int, refused: TrackRefused,
    progress: FrameProgress | None,
) -> Track:  # fmt: skip
    """The track of the first part after those ``tried`` that the frames confirm; where they confirm
    none, ``refused``, the refusal of the first one, unless another's tells more.

    Those that explain as much as is asked of a part that is believed come first: a screen beside a
    part changes more of the picture, and no turn explains it as well.
    """
    numbers = range(tried + 1, len(parts) + 1)
    rivals = [n for n in numbers if parts[n - 1].explained_there >= footage.least_tried]
    rivals.sort(key=lambda n: parts[n - 1].explained_there < TRUST.least_explained)
    for number in rivals[:_RIVALS]:
        try:
            return _of_part(footage, parts, number, Footage.measured, progress)
        except TrackRefused as again:
            better = again.rough is not None if refused.measured else again.measured
            if better and refused.rough is None:
                refused = again
    raise refused
