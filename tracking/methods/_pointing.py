"""What the user points at in footage: as a hint, in a picture, and in words where it is no part."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array
from servosight.tracking.acquisition import pointed_box
from servosight.tracking.composite import CLICKED, Hint, StabilisedSample
from servosight.tracking.core import Track, TrackOptions
from servosight.tracking.verification import small
from servosight.tracking.video import Film, frame_at
from servosight.tracking.video.drawing import SeenPart


def hint_of(
    film: Film, options: TrackOptions, stabilised: StabilisedSample, stamps_s: Array
) -> Hint | None:
    """What the user points at, if anything; ``stamps_s`` (frames,) are the file's own times."""
    box = pointed_box(options, film.images[0].shape)
    if options.pivot is None and box is None:
        return None
    frame = film.images[0]
    if options.at_s is not None:
        frame = frame_at(film.path, options.at_s, film.woven).image
    index = int(np.argmin(np.abs(stamps_s - (options.at_s or stamps_s[0]))))
    return Hint.of(stabilised, small(frame, stabilised.scale), index, options.pivot, box)


def pointed_part(stabilised: StabilisedSample, hint: Hint | None) -> SeenPart | None:
    """Where that lies in the picture that all frames were aligned with; None where it is not in
    it."""
    if hint is None:
        return None
    line, place = hint.outline_px, hint.pivot_px
    if place is None and not len(line):
        return None
    x, y = stabilised.in_video(line.mean(0) if place is None else place)
    return SeenPart((float(x), float(y)), stabilised.in_video(line))


def astray(
    track: Track, stabilised: StabilisedSample, hint: Hint | None, longer_px: float
) -> tuple[str, ...]:
    """A note where a part turns about another place than the pivot that the user points at, in
    pictures with this longer side."""
    if hint is None or hint.pivot_px is None:
        return ()
    given = stabilised.in_video(hint.pivot_px)
    away_px = float(np.hypot(*(given - np.array(track.pivot_px))))
    if away_px < CLICKED * longer_px:
        return ()
    x, y = track.pivot_px
    return (
        f"the part that was found turns about {x:.0f},{y:.0f}, {away_px:.0f} px from the pivot "
        "pointed at: look whether it is the one that is meant, with --draw",
    )


def nothing_there(options: TrackOptions, shape: tuple[int, ...]) -> str:
    """That nothing turns where the options point at, in pictures of this shape (height, width)."""
    about = ""
    if options.pivot is not None and pointed_box(options, shape) is not None:
        about = f" about the pivot {options.pivot[0]:.0f},{options.pivot[1]:.0f}"
    return (
        f"nothing that turns{about} is found at the place pointed at; expected the pivot, a point "
        "of the part or a box around it on the frame --at SECONDS"
    )
