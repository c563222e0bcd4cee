"""A small part measured in larger pictures of what is around it.

Footage is searched in pictures of 480 px, in which a part of 60 px of a large video has 20, and a
tenth of a pixel is half a degree.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.models.core import FrameProgress, Mask
from servosight.tracking.composite import FoundPart, found_about
from servosight.tracking.core import Track, TrackRefused
from servosight.tracking.methods._footage import Footage
from servosight.tracking.video import Window

_AROUND = 3.2  # radii of the part: it is not to reach the border, and what is beside it be seen
_LEAST_PX = 480  # more is not kept of a picture
_LARGER = 1.2  # times, or it is not worth it


def measured_closer(
    footage: Footage, part: FoundPart, progress: FrameProgress | None
) -> tuple[Track, Mask] | None:
    """The track of a part that was found, and in which frames (frames,) it was looked for, from
    pictures of what is around it; None where those are no larger, or the frames do not confirm it
    there. Not of a part that is pointed at, whose uncertain angle is returned, nor in colour, of
    which a file holds half of the pixels."""
    options = footage.options
    if options.pointed or options.beside is not None or not footage.stabilised.channel.luma:
        return None
    stabilised, shape = footage.stabilised, footage.film.images[0].shape
    rows = np.flatnonzero((part.part.cover > 0.5).any(1))
    if rows.size == 0:
        return None
    radius_px = float(part.part.view.radius_px[rows[-1]]) / part.scale / stabilised.scale
    x, y = stabilised.in_video(np.array(part.pivot_px))
    side = max(_LEAST_PX, int(_AROUND * radius_px))
    window = Window.around((float(x), float(y)), side, shape)
    if min(_LEAST_PX / max(window.width, window.height), 1.0) < _LARGER * stabilised.scale:
        return None
    try:
        closer = Footage.of(footage.film, options, window)
        near = closer.stabilised
        onto = stabilised.onto_near(near.reference_index)
        there = onto[:, :2] @ np.array(part.pivot_px) + onto[:, 2]
        pivot = near.of_video(stabilised.in_video(there))
        found = found_about(near.pictures, pivot, None, near.content, part.inside)
        if found is None:
            return None
        track, inside = closer.measured(found, progress)
    except TrackRefused:
        return None
    note = f"small: measured in a piece of {window.width} x {window.height} px of the pictures"
    return replace(track, notes=(note, *track.notes)), inside
