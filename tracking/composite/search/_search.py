"""From sampled pictures of a camera at rest to the part that turns in them: coarse, then fine."""

from __future__ import annotations

from dataclasses import dataclass, replace

import cv2
import numpy as np

from servosight.models.core import Array, Mask, Single
from servosight.tracking.composite._hint import Hint, pieces_for, references_for
from servosight.tracking.composite._trust import TRUST
from servosight.tracking.composite.model import cover_in, covers_in
from servosight.tracking.composite.parts import (
    Change,
    TurningPart,
    diverse,
    enough_left,
    learnt,
    without_entering,
)
from servosight.tracking.composite.search._centred import (
    FAR,
    converged,
    parts_about,
    softly_corrected,
)
from servosight.tracking.composite.search._pivots import APART, Referring, promising_pivots, scaled
from servosight.tracking.core import known_median

_MIDDLE_PX = 240  # the longer side
_PICTURES = 20
_REFINED = 2
_LEFT_SHARE = 0.015  # of the squared change, beside a part, for which another one is looked for
_MUCH_LEFT = 0.1  # of it: what is less is to be explained as well as by a part that is believed
_GAP_PX, _SHADOW_PX = 15, 11
CLICKED = 0.06  # of the longer side: how far from the pivot itself a click may be
_COVERED = 0.1
_RIVAL = 0.6  # of what the best part explains: less is not made up for by a better pivot


@dataclass(frozen=True)
class FoundPart:
    """A part that turns: its pivot in pixels of the given pictures, its model in pictures
    ``scale`` times as large, and the mean share of a picture's change that it explains.

    ``inside`` says that what enters the picture was left out, ``beside`` (height, width), if it is
    not None, where a part passes that explains more and was left out. ``reach_px`` is how far from
    its pivot it may reach, if that is known.
    """

    pivot_px: tuple[float, float]
    scale: float
    part: TurningPart
    explained: float
    inside: bool = False
    beside: Mask | None = None
    reach_px: float | None = None

    @property
    def explained_there(self) -> float:
        """The share of what changes in the pictures in which it was found."""
        return self.part.explained

    @property
    def radius_px(self) -> float:
        """Of its farthest cell, in pixels of the given pictures."""
        return self.part.radius_px / self.scale


def find_parts(
    pictures: Single, hint: Hint | None = None, content: Mask | None = None
) -> list[FoundPart]:
    """The parts that turn, the one that explains most of the change first; pictures (n, height,
    width) of one camera position. With a hint, only those that it points at.

    ``content`` (height, width) is what is known in all pictures, everything if None. Without a
    hint, what enters the picture is left out where enough else changes; where no part explains
    enough of the change so, or of what a hint points at, the other way is tried as well.
    """
    found: list[FoundPart] = []
    for inside in _ways(pictures, hint, content):
        seen = chosen_of(pictures, hint, content, inside)
        found += [replace(one, inside=inside) for one in _found_in(seen, hint)]
        if any(one.explained >= TRUST.least_explained for one in found):
            break
    return _distinct(sorted(found, key=lambda one: -one.explained), APART * max(pictures.shape[1:]))


def parts_otherwise(
    pictures: Single, found: list[FoundPart], hint: Hint | None = None, content: Mask | None = None
) -> list[FoundPart]:
    """Further parts, where those ``found`` first turn out to be none: with what enters the picture
    left out if it was not, or the other way round; empty where that makes no difference, or was
    tried."""
    if not found or found[0].explained < TRUST.least_explained:
        return []
    others: list[FoundPart] = []
    for inside in _ways(pictures, hint, content):
        if all(one.inside != inside for one in found):
            seen = chosen_of(pictures, hint, content, inside)
            others += [replace(one, inside=inside) for one in _found_in(seen, hint)]
    ordered = sorted(others, key=lambda one: -one.explained)
    return _distinct([*found, *ordered], APART * max(pictures.shape[1:]))[len(found) :]


def _ways(pictures: Single, hint: Hint | None, content: Mask | None) -> tuple[bool, ...]:
    """Whether to leave out what enters the pictures, the more promising way first."""
    cleared = without_entering(pictures, content)
    if cleared is pictures:
        return (False,)
    inside = hint is None and enough_left(pictures, cleared)
    return inside, not inside


def _found_in(seen: Single, hint: Hint | None) -> list[FoundPart]:
    """The parts in chosen pictures. Without a hint, a second search follows where the best part
    does not pass, if enough changes there: a smaller part with less contrast is some hundredths of
    the squared change. Its pivot is to be in the picture: about one far away anything turns.

    What a place on the part shows alone turns about many pivots, as a piece of a straight edge
    does: so parts of all that changes are added, if they lie at that place."""
    found = _parts(seen, hint, hint)
    if hint is not None and hint.region is not None and hint.pivot_px is None:
        found += _parts(seen, None, hint)
    if found and hint is None:
        beside = _swept(seen.shape[1:], found[0])
        away = np.where(beside, known_median(seen), seen)
        share = float(Change.of(away).energy.sum() / max(Change.of(seen).energy.sum(), 1.0))
        if share > _LEFT_SHARE:
            least = TRUST.least_explained if share < _MUCH_LEFT else 0.0
            others = [
                one
                for one in _parts(away, None, None, 1)
                if one.explained >= least and _in_view(one, seen.shape[1:])
            ]
            found += [
                replace(one, explained=share * one.explained, beside=beside) for one in others
            ]
    return found


def _in_view(part: FoundPart, shape: tuple[int, ...]) -> bool:
    """Whether a part's pivot lies in pictures (height, width)."""
    x, y = part.pivot_px
    return 0.0 <= x < shape[1] and 0.0 <= y < shape[0]


def found_about(
    pictures: Single, pivot_px: Array, hint: Hint | None = None, content: Mask | None = None,
    inside: bool = True, beside: Mask | None = None, reach_px: float | None = None,
) -> FoundPart | None:  # fmt: skip
    """The part learnt anew about a pivot (2,) that is better known; None where nothing holds.

    ``inside``: what enters the picture is left out; the others are as in ``FoundPart``.

    A part that was learnt about a wrong pivot has a wrong shape: some of it is taken for
    background, and its angles are then too small.
    """
    if beside is not None:
        pictures = np.where(beside, known_median(pictures), pictures)
    seen = chosen_of(pictures, hint, content, inside)
    middle, scale = scaled(seen, _MIDDLE_PX)
    change = Change.of(middle)
    near = hint.scaled(scale) if hint is not None else None
    x, y = (pivot_px + 0.5) * scale - 0.5
    reach = FAR * max(middle.shape[1:])
    if reach_px is not None:
        reach = min(reach, scale * reach_px)
    for referring in (references_for, pieces_for) if _in_pieces(near) else (references_for,):
        references = referring(middle, change, near)
        part = learnt(middle, change, (float(x), float(y)), reach, references)
        if part is not None and part.explained >= TRUST.least_measured:
            break
    if part is None:
        return None
    better = _as_found(converged(middle, change, part, references), scale)
    return replace(better, inside=inside, beside=beside, reach_px=reach_px)


def chosen_of(pictures: Single, hint: Hint | None, content: Mask | None, inside: bool) -> Single:
    """Some of the pictures (n, height, width) that differ most; without what enters them if
    ``inside``, with a hint only with what is connected with the place pointed at."""
    seen = without_entering(pictures, content) if inside else pictures
    seen = seen[diverse(seen, _PICTURES)]
    return _connected(seen, hint.place) if hint is not None else seen


def _as_found(part: TurningPart, scale: float) -> FoundPart:
    x, y = (np.array(part.view.pivot_px) + 0.5) / scale - 0.5
    return FoundPart((float(x), float(y)), scale, part, part.explained)


def _parts(
    pictures: Single, start: Hint | None, wanted: Hint | None, refined: int = _REFINED
) -> list[FoundPart]:
    """The parts that turn in chosen pictures; the pivots of the best ``refined`` are corrected.

    The search starts at what ``start`` points at, or at all that changes; of the parts that it
    finds those are returned that ``wanted`` points at, or all."""
    middle, scale = scaled(pictures, _MIDDLE_PX)
    change = Change.of(middle)
    if not change.moved.any():
        return []
    at, near = (None if one is None else one.scaled(scale) for one in (start, wanted))
    references = references_for(middle, change, at)
    given = None if at is None else at.pivot_px

    def starts_by(referring: Referring) -> list[Array]:
        return [given] if given is not None else promising_pivots(pictures, scale, start, referring)

    starts = starts_by(references_for)
    rough = parts_about(middle, change, starts, references)
    if all(part.explained < TRUST.least_measured for part in rough):
        rough += parts_about(middle, change, softly_corrected(middle, starts, at), references)
    if _in_pieces(at) and all(part.explained < TRUST.least_measured for part in rough):
        references = pieces_for(middle, change, at)
        rough += parts_about(middle, change, starts_by(pieces_for), references)
    found: list[FoundPart] = []
    for rank, part in enumerate(sorted(rough, key=lambda one: -one.explained)[:_REFINED]):
        far_off = part.explained < _RIVAL * found[0].explained if found else False
        better = part
        if rank < refined and not far_off:
            better = converged(middle, change, part, references)
        if near is None or _pointed_at(better, near):
            found.append(_as_found(better, scale))
    return found


def _in_pieces(hint: Hint | None) -> bool:
    """Whether pieces of what changes can be tried: not where one place is pointed at."""
    return hint is None or hint.region is None


def _connected(pictures: Single, region: Mask) -> Single:
    """The pictures with only that change which is connected with a region, if any is."""
    change = Change.of(pictures)
    near = change.often
    # Closed, because a fast part leaves gaps between the sampled frames.
    closed = cv2.dilate((near | region).astype(np.uint8), np.ones((_GAP_PX, _GAP_PX), np.uint8))
    _, labels = cv2.connectedComponents(closed)
    own = np.isin(labels, labels[region])
    return np.where(own, pictures, change.usual) if (own & near).any() else pictures


def _swept(shape: tuple[int, ...], found: FoundPart) -> Mask:
    """Where a part passes in pictures (height, width)."""
    part = found.part
    height, width = shape
    size = (max(1, round(found.scale * height)), max(1, round(found.scale * width)))
    swept = np.zeros(size, np.uint8)
    for cover in covers_in(part.view, part.cover > 0.5, part.angle_rad.tolist(), size):
        swept |= cover.astype(np.uint8)
    grown = cv2.dilate(swept, np.ones((_SHADOW_PX, _SHADOW_PX), np.uint8))
    whole = cv2.resize(grown, (width, height), interpolation=cv2.INTER_NEAREST)
    return np.asarray(whole) > 0


def _pointed_at(part: TurningPart, hint: Hint) -> bool:
    """Whether a part turns about the pivot, and lies at the place, that the user points at."""
    if hint.pivot_px is not None:
        away = np.hypot(*(np.array(part.view.pivot_px) - hint.pivot_px))
        if away > CLICKED * max(hint.picture.shape):
            return False
    if hint.region is None:
        return True
    view = part.view
    gains = view.gains(view.of(hint.picture), part.behind, part.part, part.cover)
    angle = float(view.angles()[int(np.argmax(gains))])
    cover = cover_in(view, part.cover > 0.5, angle, hint.picture.shape)
    least = _COVERED * min(int(hint.region.sum()), int(cover.sum()))
    return int((cover & hint.region).sum()) > least


def _distinct(found: list[FoundPart], distance_px: float) -> list[FoundPart]:
    """Without those whose pivot is that of a better one."""
    kept: list[FoundPart] = []
    for one in found:
        away = [np.hypot(*np.subtract(one.pivot_px, other.pivot_px)) for other in kept]
        if all(distance > distance_px for distance in away):
            kept.append(one)
    return kept
