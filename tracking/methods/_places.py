"""A part looked for in one place at a time, where more changes beside it that does not turn.

Someone who moves in the picture changes more of it than the part does. Where the pictures are
looked at as a whole, pieces of that are all that is found.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from scipy.sparse.csgraph import connected_components

from servosight.models.core import Array, FrameProgress, Mask, Single
from servosight.tracking.composite import TRUST, Change, without_entering
from servosight.tracking.core import Track, TrackRefused
from servosight.tracking.methods._footage import Footage
from servosight.tracking.methods._notes import with_choice
from servosight.tracking.video import Window

_MOST = 3
_LEAST_SHARE = 0.001  # of the squared change: less is the codec's
_GAP_PX = 7  # a fast part leaves gaps between the sampled frames; a screen may be as near
_LASTING = 0.01  # of the largest change: passers-by left 0.000, and parts 0.1 to 0.75
_AROUND = 2.0  # sizes of the place: a pivot may lie beside what changes


def measured_in_places(
    footage: Footage, refused: TrackRefused, progress: FrameProgress | None
) -> Track:
    """The track of the part in the first of the places where most changes whose own pictures
    confirm one; ``refused`` where none do, where the user points at a part, or where it has an
    uncertain angle. Where it has none, and a place has, the refusal of that place.

    A part must explain as much of what changes there as one that is believed.
    """
    options, stabilised = footage.options, footage.stabilised
    alone = options.beside is None and options.pick == 1 and not stabilised.coloured
    if options.pointed or not alone or footage.window is not None or refused.rough is not None:
        raise refused
    for window in _windows(footage):
        try:
            return _in_place(_measured(Footage.of(footage.film, options, window), progress), window)
        except TrackRefused as there:
            if there.rough is not None and refused.rough is None:
                refused = there
                refused.rough = _in_place(there.rough, window)
    raise refused


def _in_place(track: Track, window: Window) -> Track:
    """The track, with a note on where it was found."""
    note = (
        f"found in a piece of {window.width} x {window.height} px of the pictures: elsewhere "
        "more changes that does not turn"
    )
    return replace(track, notes=(note, *track.notes))


def _measured(place: Footage, progress: FrameProgress | None) -> Track:
    """The track of the part that explains most of what changes in a place."""
    parts = place.parts()
    if not parts or parts[0].explained_there < TRUST.least_explained:
        raise place.nothing(parts)
    return with_choice(place.measured(parts[0], progress), [place.candidate(parts[0])], 1)


def _windows(footage: Footage) -> list[Window]:
    """The pieces of the pictures around the places in which most changes; around those beside each
    other, as one, first."""
    stabilised = footage.stabilised
    places = _places(without_entering(stabilised.pictures, stabilised.content))
    shape = footage.film.images[0].shape
    windows = []
    for place in (*_joint(places), *places):
        middle, size = _middle_and_size(place)
        x, y = stabilised.in_video(middle)
        side_px = size / stabilised.scale + 2.0 * stabilised.sway_px  # the camera moves the part
        windows.append(Window.around((float(x), float(y)), round(side_px), shape))
    whole = shape[0] * shape[1]
    return [one for one in windows if 2 * one.width * one.height < whole]


def _middle_and_size(place: Mask) -> tuple[Array, float]:
    """The middle x, y of a place in the pictures, and the side of the square to look at."""
    rows, columns = (np.flatnonzero(place.any(axis)) for axis in (1, 0))
    middle = np.array([columns[[0, -1]].mean(), rows[[0, -1]].mean()])
    return middle, _AROUND * float(max(np.ptp(columns), np.ptp(rows)))


def _joint(places: list[Mask]) -> list[Mask]:
    """Places of which one lies around another, as one: of a plate that turns a little only the
    edges change, each in a place of its own, and one alone turns about many pivots."""
    near = np.array([[_around(one)[other].any() for other in places] for one in places])
    count, group = connected_components(near.reshape(len(places), len(places)))
    groups = [np.flatnonzero(group == number) for number in range(count)]
    return [np.any([places[n] for n in one], axis=0) for one in groups if one.size > 1]


def _around(place: Mask) -> Mask:
    """The square about a place that is looked at."""
    middle, size = _middle_and_size(place)
    y, x = np.indices(place.shape)
    return np.asarray(np.maximum(abs(x - middle[0]), abs(y - middle[1])) <= 0.5 * size)


def _places(pictures: Single) -> list[Mask]:
    """The connected places (height, width) in which pictures (n, height, width) change often, with
    more than a little of the squared change: that with most of it, which outweighs the others in
    whole pictures, at the end. Not those that someone passes."""
    change = Change.of(pictures)
    if not change.often.any():
        return []
    grown = cv2.dilate(change.often.astype(np.uint8), np.ones((_GAP_PX, _GAP_PX), np.uint8))
    labels = cv2.connectedComponents(grown)[1]
    squares = (pictures - change.usual) ** 2 * change.moved
    shares = np.bincount(labels.ravel(), squares.sum(0).ravel()) / squares.sum()
    shares[0] = 0.0
    first, *others = np.argsort(-shares, kind="stable")[:_MOST].tolist()
    places = [labels == number for number in (*others, first) if shares[number] > _LEAST_SHARE]
    return [place for place in places if _lasting(squares[:, place].sum(1))]


def _lasting(squares: Array) -> bool:
    """Whether a place with such a squared change in each picture (n,) differs from how it usually
    looks in half of the pictures; with a passer-by it does not in most of them."""
    return bool(np.median(squares) > _LASTING * squares.max())
