"""A small part measured in larger pictures of what is around it.

Footage is searched in pictures of 480 px, in which a part of 60 px of a large video has 20, and a
tenth of a pixel is half a degree.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.models.core import FrameProgress
from servosight.tracking.composite import FoundPart, found_about
from servosight.tracking.core import Track, TrackRefused
from servosight.tracking.methods._footage import Footage
from servosight.tracking.video import Window

_AROUND = 3.2  # radii of the part: it is not to reach the border, and what is beside it be seen
_LEAST_PX = 480  # more is not kept of a picture
_LARGER = 1.2  # times, or it is not worth it
_REACH = 1.25  # radii: what lies farther from the pivot is not the part


def measured_closer(footage: Footage, part: FoundPart, progress: FrameProgress | None) -> Track:
    """The track of a part that was found, from pictures of what is around it; ``TrackRefused``
    where those are no larger, or the frames do not confirm it there. Not of a part that is pointed
    at, whose uncertain angle is returned, nor in colour, of which a file holds half of the
    pixels."""
    stabilised = footage.stabilised
    radius_px = part.radius_px / stabilised.scale
    window = _window(footage, part, radius_px)
    if window is None:
        raise footage.nothing([])
    closer = replace(Footage.of(footage.film, footage.options, window), tilt=footage.tilt)
    if stabilised.shadow is not None:
        lit = closer.without_shadow()
        if lit is None:
            raise footage.nothing([])
        closer = lit
    near = closer.stabilised
    onto = stabilised.onto_near(near.reference_index)
    there = onto[:, :2] @ np.array(part.pivot_px) + onto[:, 2]
    pivot = near.of_video(stabilised.in_video(there))
    found = found_about(
        near.pictures, pivot, None, near.content, part.inside,
        reach_px=_REACH * radius_px * near.scale,
    )  # fmt: skip
    if found is None:
        raise closer.nothing([])
    note = f"small: measured in a piece of {window.width} x {window.height} px of the pictures"
    try:
        track = closer.measured(found, progress)
    except TrackRefused as refused:
        if refused.rough is not None:
            refused.rough = replace(refused.rough, notes=(note, *refused.rough.notes))
        raise
    return replace(track, notes=(note, *track.notes))


def _window(footage: Footage, part: FoundPart, radius_px: float) -> Window | None:
    """The piece of the pictures around a part of that radius; None where it shows it no larger, or
    none is to be looked at."""
    stabilised, options = footage.stabilised, footage.options
    alone = options.beside is None and stabilised.channel.luma
    if options.pointed or not alone:
        return None
    x, y = stabilised.in_video(np.array(part.pivot_px))
    side = max(_LEAST_PX, int(_AROUND * radius_px))
    window = Window.around((float(x), float(y)), side, footage.film.images[0].shape)
    larger = min(_LEAST_PX / max(window.width, window.height), 1.0) / stabilised.scale
    return window if larger >= _LARGER else None
