"""A turning part from pictures in which nothing is known: pivot, angles, picture and shape.

For every possible pivot: how much of what changes does a piece of one picture, turned about it,
explain in the others? In polar coordinates that is a correlation. No features are needed, so that a
plain bar does; from the best pivots on, part and background are learnt in turn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from scipy import ndimage

from servosight.models.core import Array, Mask, Single
from servosight.tracking.composite.parts._turned_back import misfits, turned_back, without_part
from servosight.tracking.core import known_median, threaded
from servosight.tracking.verification import Gains, PolarView, rows_of

_SIGMAS, _LEAST_STEP = 4.0, 5.0
_MOVED_SHARE = 0.04  # of the pictures in which a place must change
_REFERENCES = (0.5, 0.75, 0.95)  # quantiles of the change
_PIECE_SHARE = 0.1  # of a reference's change
_JOINED_PX = 3
_CLOSED = 3  # cells
_ROUNDS = 4
_OWN_SHARE = 0.5
# Of the pictures: by fewer, as of a place that is hardly ever in view, anything seems to turn.
_KNOWN_SHARE = 0.3


@dataclass(frozen=True)
class TurningPart:
    """A part found in sampled pictures; all on the raster ``view``.

    ``angle_rad`` (pictures,) relative to the picture it was learnt from, ``behind`` the background,
    ``part`` and ``cover`` its picture and shape (rows, columns) at angle zero, ``explained`` the
    mean share of a picture's change that it explains.
    """

    view: PolarView
    angle_rad: Array
    behind: Single
    part: Single
    cover: Single
    explained: float

    @property
    def radius_px(self) -> float:
        """Of its farthest cell."""
        return float(self.view.radius_px[np.flatnonzero(self.cover.any(1))[-1]])


def diverse(pictures: Single, count: int) -> list[int]:
    """Pictures (n, height, width) that differ most from each other, by number; rising.

    A part that rests long in one place is then seen as often elsewhere.
    """
    small = np.stack([cv2.resize(p, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
                      for p in pictures])  # fmt: skip
    small = np.minimum(np.abs(small - known_median(small)), 40.0).reshape(len(small), -1)
    chosen = [int(np.argmin(small.sum(1)))]
    away = np.full(len(small), np.inf)
    while len(chosen) < min(count, len(small)):
        away = np.minimum(away, ((small - small[chosen[-1]]) ** 2).sum(1))
        chosen.append(int(np.argmax(away)))
    return sorted(set(chosen))


@dataclass(frozen=True)
class Change:
    """What changes in pictures (n, height, width): their median, each one's difference from it with
    noise set to zero, and the energy of that (n,)."""

    usual: Single
    energy: Array
    moved: Mask
    noise: float

    @classmethod
    def of(cls, pictures: Single) -> Change:
        """By the pictures' own noise."""
        usual = known_median(pictures)
        away = pictures - usual
        noise = 1.4826 * float(np.median(np.abs(away[:, ::2, ::2])))
        moved = np.abs(away) > _SIGMAS * noise + _LEAST_STEP
        return cls(usual, (away**2 * moved).sum((1, 2)), moved, noise)

    @property
    def telling(self) -> Mask:
        """The pictures in which enough changes to tell anything; (n,)."""
        return np.asarray(self.energy > 0.1 * np.median(self.energy))

    @property
    def often(self) -> Mask:
        """Where enough of the pictures change; (height, width)."""
        return np.asarray(self.moved.mean(0) > _MOVED_SHARE)

    @property
    def least_step(self) -> float:
        """The smallest difference of grey levels that counts as change."""
        return _SIGMAS * self.noise + _LEAST_STEP


@dataclass(frozen=True)
class Reference:
    """A picture (height, width) and which of its pixels are taken for the part's, 0 to 1.

    ``number`` is its own among the pictures that it is compared with, None where it is not one.
    """

    picture: Single
    cover: Single
    number: int | None = None


def references_of(pictures: Single, change: Change) -> list[Reference]:
    """Pictures in which much changes, with all that does."""
    order = np.argsort(change.energy)
    numbers = [int(order[int(q * (len(order) - 1))]) for q in _REFERENCES]
    return [Reference(pictures[n], change.moved[n].astype(np.float32), n) for n in numbers]


def pieces_of(references: Sequence[Reference], change: Change) -> list[Reference]:
    """Each connected piece of what the references cover, as one of its own.

    Of a text that is laid over the pictures, a shadow, or the place that a part has left, none
    turns with the part, and a reference that covers them as well finds no turn. The references
    themselves where no piece is large.
    """
    kernel = np.ones((_JOINED_PX, _JOINED_PX), np.uint8)
    pieces = []
    for one in references:
        energy = one.cover * (one.picture - change.usual) ** 2
        joined = cv2.dilate((one.cover > 0.5).astype(np.uint8), kernel)
        count, labels = cv2.connectedComponents(joined)
        share = ndimage.sum_labels(energy, labels, np.arange(1, count)) / max(energy.sum(), 1.0)
        pieces += [
            replace(one, cover=np.where(labels == label, one.cover, np.float32(0.0)))
            for label in 1 + np.flatnonzero(share > _PIECE_SHARE)
        ]
    return pieces or list(references)


def pivot_scores(
    pictures: Single, change: Change, pivots: Array, reach_px: float, references: list[Reference]
) -> Array:
    """Share of the change that a turn of each reference about each of the pivots (m, 2) explains;
    (m, references)."""

    def about(pivot: Array) -> list[float]:
        view = PolarView.around((float(pivot[0]), float(pivot[1])), reach_px)
        seen = np.stack([view.of(picture) for picture in pictures])
        gains = Gains.of(view, seen, view.of(change.usual))
        return [_explained_by(one, view, seen, gains, change) for one in references]

    return np.array(threaded(about, list(pivots))).reshape(len(pivots), len(references))


def _explained_by(
    one: Reference, view: PolarView, seen: Single, gains: Gains, change: Change
) -> float:
    """Mean share of the change that a turn of the reference explains in pictures ``seen`` on the
    raster (n, rows, columns)."""
    picture = view.of(one.picture) if one.number is None else seen[one.number]
    best = gains.by(picture, view.of(one.cover, outside=0.0)).max(1)
    share = _share(best, view, change)
    if one.number is not None:
        share[one.number] = 0.0
    return _mean_where_telling(share, change)


def _share(gain: Array, view: PolarView, change: Change) -> Array:
    """Gains (pictures,) as shares of the pictures' change, 0 to 1."""
    # The raster's weight is the area, so that gains are those of pixels.
    share = gain * view.step_rad * view.step_px / np.maximum(change.energy, 1.0)
    return np.asarray(np.clip(share, 0.0, 1.0))


def _mean_where_telling(share: Array, change: Change) -> float:
    """Mean share (pictures,) of the pictures that tell anything; 0 where none does."""
    telling = share[change.telling]
    return float(telling.mean()) if telling.size else 0.0


def learnt(
    pictures: Single,
    change: Change,
    pivot_px: tuple[float, float],
    reach_px: float,
    references: list[Reference],
) -> TurningPart | None:
    """The part about a pivot, learnt in turn with the background; None where nothing holds.

    It starts from the reference that explains most.
    """
    view = PolarView.around(pivot_px, reach_px)
    seen = np.stack([view.of(picture) for picture in pictures])
    behind = view.of(change.usual)
    gains = Gains.of(view, seen, behind)
    start = max(references, key=lambda one: _explained_by(one, view, seen, gains, change))
    part, cover = view.of(start.picture), view.of(start.cover, outside=0.0)
    angles = view.angles()
    for _ in range(_ROUNDS):
        gain = gains.by(part, cover)
        found = angles[np.argmax(gain, axis=1)]
        turns = np.round(found / view.step_rad).astype(int)
        good = gain.max(1) > 0.0
        if good.sum() < 5:
            return None
        wide = cv2.copyMakeBorder(cover, 0, 0, 2, 2, cv2.BORDER_WRAP)
        thick = cv2.dilate(wide, np.ones((5, 5)))[:, 2:-2] > 0.3
        behind = known_median(without_part(seen, thick, turns), least=2)
        part = known_median(turned_back(seen[good], turns[good]), least=2)
        own, against, share = misfits(seen[good], turns[good], part, behind)
        against = np.where(share > _KNOWN_SHARE, _local(against), np.float32(np.nan))
        cover = _shape(_local(own), against, change.noise, view)
        if not cover.any():
            return None
        gains = Gains.of(view, seen, behind, rows_of(cover))
    gain = gains.by(part, cover)
    explained = _mean_where_telling(_share(gain.max(1), view, change), change)
    return TurningPart(view, angles[np.argmax(gain, axis=1)], behind, part, cover, explained)


def _shape(own: Single, against: Single, noise: float, view: PolarView) -> Single:
    """1 on cells that turn with the part rather than stay with the background; largest piece."""
    turns = (own < _OWN_SHARE * against) & (against > 9.0 * noise**2 + 16.0)  # not where NaN
    tiled = np.tile(turns.astype(np.uint8), (1, 3))
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    grown = cv2.dilate(tiled, cross, iterations=_CLOSED, borderType=cv2.BORDER_CONSTANT)
    closed = cv2.erode(
        grown, cross, iterations=_CLOSED, borderType=cv2.BORDER_CONSTANT, borderValue=0
    )
    first = view.columns // 2
    twice = np.ascontiguousarray(closed[:, first : first + 2 * view.columns])
    count, labels = cv2.connectedComponents(twice, connectivity=4)
    if count == 1:
        return np.zeros(own.shape, np.float32)
    # Rounded, so that a piece counts once although the raster is shown twice.
    area = np.broadcast_to(view.radius_px[:, None], labels.shape)
    sizes = np.bincount(labels.ravel(), area.ravel())
    sizes[0] = 0.0
    kept = (sizes > 0.25 * sizes.max())[labels]
    whole = kept[:, : view.columns] | kept[:, view.columns :]
    return np.asarray(np.roll(whole, first, axis=1), np.float32)


def _local(values: Single) -> Single:
    """Means over 3 x 3 cells, the columns going round; NaN where less than a third is known."""
    known = np.isfinite(values)
    pair = np.dstack([np.where(known, values, np.float32(0.0)), known.astype(np.float32)])
    wide = cv2.copyMakeBorder(pair, 0, 0, 1, 1, cv2.BORDER_WRAP)
    mean = cv2.blur(wide, (3, 3), borderType=cv2.BORDER_REPLICATE)[:, 1:-1]
    total, share = mean[..., 0], mean[..., 1]
    least = np.float32(0.3)
    return np.where(share > least, total / np.maximum(share, least), np.float32(np.nan))
