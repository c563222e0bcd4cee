"""The part learnt from all sampled frames, and every frame measured."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from servosight.models.core import Array, Image, Mask, Single
from servosight.tracking.composite._contours import contour, contours
from servosight.tracking.composite._matting import with_cover
from servosight.tracking.composite._refit import Refit, refitted
from servosight.tracking.composite._rigid_check import shifting_rad
from servosight.tracking.composite._sighting import Sighting, farthest_rad, followed
from servosight.tracking.composite._stabilised import StabilisedSample, evenly
from servosight.tracking.composite._trust import TRUST
from servosight.tracking.composite.camera import Background, aligned, motion_from
from servosight.tracking.composite.model import (
    CompositeModel,
    PoseFit,
    cover_in,
    covers_in,
)
from servosight.tracking.composite.oblique import SampledPart
from servosight.tracking.composite.parts import TurningPart
from servosight.tracking.composite.search import FoundPart
from servosight.tracking.core import known_median, turned
from servosight.tracking.verification import PolarView, small
from servosight.tracking.video import Frame

_ROUNDS, _ENOUGH_PX = 7, 0.05
_AS_MANY = 0.95  # of the pictures in which the part was found about another pivot
_AS_GOOD = 0.8
_HOLE = 0.02
_SOME = 24
_IN_VIEW = 0.5  # of the largest area in which the part is seen
_BESIDE_PX = (-12.0, -6.0, 6.0, 12.0)  # at the part's farthest cell


@dataclass(frozen=True)
class PartMeter:
    """Measures a found part in frame after frame; pixels are those of the stabilised sample.

    ``rough`` is the part on a coarser raster, for a search over all angles; ``shape`` (rows,
    columns) the part's on ``view``, ``doubt_px`` the sigma of the pivot, ``known_rad`` (n,) its
    angles in the sampled pictures, NaN where they do not show it, ``cover_rad`` the sigma of angles
    by how much of its cells the part covers. ``features`` (height, width) is not 0, and
    ``background`` lies, where the part never passes.
    """

    stabilised: StabilisedSample
    model: CompositeModel
    view: PolarView
    shape: Single
    rough: TurningPart
    rough_scale: float
    features: Image
    background: Background | None
    doubt_px: float
    known_rad: Array
    cover_rad: float = 0.0

    @classmethod
    def of(cls, stabilised: StabilisedSample, found: FoundPart) -> PartMeter:
        """Learn the part on all sampled pictures, its pivot with it."""
        rough = found.part
        rough_scale = found.scale
        pivot = np.array(found.pivot_px)
        pictures = stabilised.pictures
        angles = followed(rough, rough_scale, pictures, stabilised.index)
        good = np.ones(len(angles), bool)
        first, rough_shape = _finer(rough, rough_scale, pivot)
        # At angle zero the part lies where it lies, whatever its pivot is.
        still = cover_in(first, rough_shape > 0.5, 0.0, stabilised.content.shape).astype(np.float32)
        usual = known_median(pictures)
        kept: list[tuple[CompositeModel, PolarView, Single, Refit]] = []
        most = 0
        for number in range(_ROUNDS):
            reach = first.rows * first.step_px + float(np.hypot(*(pivot - first.pivot_px)))
            view = PolarView.around((float(pivot[0]), float(pivot[1])), reach)
            shape = (np.nan_to_num(view.of(still)) > 0.5).astype(np.float32)
            place = (float(pivot[0]), float(pivot[1]))
            model = CompositeModel.of(
                pictures[good], angles[good], place, shape, view, usual, stabilised.channel.grain
            )
            fit = refitted(model, pictures, angles)
            angles, good = fit.angle_rad, fit.good
            # The corrections may lead away where the part hardly shows its own direction.
            most = max(most, int(good.sum()))
            if good.sum() >= _AS_MANY * most:
                kept.append((model, view, shape, fit))
            if number and np.hypot(*fit.step_px) < _ENOUGH_PX:
                break
            pivot = pivot + fit.step_px
        model, view, shape, fit = kept[-1]
        angles, good, doubt_px = fit.angle_rad, fit.good, fit.doubt_px
        swept = np.zeros(stabilised.content.shape, np.uint8)
        for cover in covers_in(view, shape > 0.5, _some(angles[good]), swept.shape):
            swept |= cover.astype(np.uint8)
        if stabilised.shaded is not None:
            swept |= stabilised.shaded.astype(np.uint8)
        clear = (cv2.dilate(swept, np.ones((9, 9), np.uint8)) == 0) & stabilised.content
        features = np.asarray(255 * clear, np.uint8)
        behind = stabilised.guide if stabilised.coloured else model.behind
        background = Background.of(behind, clear) if stabilised.moves else None
        known = np.where(good, angles, np.nan)
        return cls(
            stabilised, model, view, shape, rough, rough_scale, features, background, doubt_px,
            known,
        )  # fmt: skip

    def covered(self) -> PartMeter:
        """With the cover of the part's cells learnt, where that explains more of the pictures."""
        pictures, good = self.stabilised.pictures, np.isfinite(self.known_rad)
        model, cover_rad = with_cover(
            self.model, pictures[good], self.known_rad[good], self.shape, self.view,
            known_median(pictures),
        )  # fmt: skip
        return replace(self, model=model, cover_rad=cover_rad)

    @property
    def pivot_px(self) -> Array:
        """In the pixels of the stabilised sample (2,)."""
        return np.array(self.model.pivot_px)

    @property
    def visible(self) -> bool:
        """Whether the part is in the picture at an angle of the sampled pictures."""
        return any(cover.any() for cover in self._covers(_some(self._known)))

    def outline(self, angle_rad: float) -> Array:
        """The part's contour at an angle (points, 2)."""
        cover, left_rad = self._in_view(angle_rad)
        return turned(contour(cover), self.model.pivot_px, left_rad)

    def pieces(self, angle_rad: float) -> list[Array]:
        """The contours (points, 2) of the part's pieces at an angle, and of the holes in them: the
        background is seen between the arms of a cross, and between the spokes of a wheel."""
        cover, left_rad = self._in_view(angle_rad)
        lines = contours(cover, cv2.RETR_CCOMP, _HOLE)
        return [turned(line, self.model.pivot_px, left_rad) for line in lines]

    def _in_view(self, angle_rad: float) -> tuple[Mask, float]:
        """The part at an angle, and no turn [rad] that is left to it; or, where half of it is not
        in the picture there, at the known angle at which most of it is, and the turn from there."""
        cover = next(self._covers([angle_rad]))
        known = _some(self._known)
        best, largest = max(
            zip(known, self._covers(known), strict=True), key=lambda one: int(one[1].sum())
        )
        if cover.sum() > _IN_VIEW * largest.sum():
            return cover, 0.0
        return largest, angle_rad - best

    @property
    def _known(self) -> Array:
        return self.known_rad[np.isfinite(self.known_rad)]

    def _covers(self, angles_rad: Iterable[float]) -> Iterator[Mask]:
        return covers_in(self.view, self.shape > 0.5, angles_rad, self.stabilised.content.shape)

    @property
    def radius_px(self) -> float:
        """Of the part's farthest cell."""
        return float(self.model.radius_px.max())

    @property
    def gain(self) -> float:
        """By how much less the part leaves of the sampled pictures than the background alone, mean
        [grey levels^2 px^2]."""
        pictures, known = self.stabilised.pictures, np.isfinite(self.known_rad)
        fits = self.model.fits(pictures[known], self.known_rad[known])
        total = sum(fit.gain for fit in fits if fit is not None)
        return float(total * self.view.step_px / len(pictures))

    def sampled(self, shape: tuple[int, ...]) -> SampledPart:
        """What the plane of motion is found from, of a video with pictures of a ``shape`` (height,
        width)."""
        still = next(self._covers([0.0])).astype(np.float32)
        reach = self.view.rows * self.view.step_px
        stabilised, grain = self.stabilised, self.model.grain
        return SampledPart(
            stabilised.pictures,
            self.model.behind,
            still,
            self.pivot_px,
            reach,
            self.radius_px,
            grain,
            stabilised.of_video(0.5 * (np.array(shape[1::-1]) - 1.0)),
            max(shape) * stabilised.scale,
        )

    def apart_rad(self, fits: Sequence[PoseFit | None]) -> float:
        """The rms [rad] by which angles (frames,) change, beyond chance, where the part may also
        shift: as with a pivot that is off. From the sampled frames."""
        index = self.stabilised.index.tolist()
        sampled = [fits[n] if n < len(fits) else None for n in index]
        return shifting_rad(self.model, self.stabilised.pictures, sampled)

    def in_sampled(self, angle_rad: Array) -> Array:
        """Those of all frames' angles (frames,) that are of the sampled ones, NaN beyond."""
        index = self.stabilised.index.astype(int)
        beyond = np.append(angle_rad, np.nan)
        return np.asarray(beyond[np.minimum(index, angle_rad.size)])

    def measured(
        self, frames: Iterable[Frame], first: int, last: int
    ) -> Iterator[tuple[Frame, PoseFit | None, Array]]:
        """Each frame with its fit, and the turns (m,) [rad] to other angles at which the part looks
        the same; None where it is not found, and outside of the frames ``first`` to ``last``.

        Where the camera does not rest, only a part of which the frame explains as much as is asked
        of one that is believed is found.
        """
        before: float | None = None
        since = 1
        for frame in frames:
            inside = first <= frame.index <= last
            near = None if before is None else (before, farthest_rad(self.rough, since))
            fit, rivals = self._fit(frame, near) if inside else (None, np.empty(0))
            if (
                fit
                and not self.stabilised.rests(frame.index)
                and (fit.explained < TRUST.least_explained)
            ):
                fit = None
            # A wheel that looks the same at several angles would jump after a frame without it.
            before, since = (fit.angle_rad, 1) if fit is not None else (before, since + 1)
            yield frame, fit, rivals

    def _fit(self, frame: Frame, near: tuple[float, float] | None) -> tuple[PoseFit | None, Array]:
        """The part in a frame, near an angle as far as the second number says [rad] if it may be,
        and the turns (m,) [rad] to others at which it looks the same."""
        picture = small(frame.image, self.stabilised.scale)
        onto = np.eye(2, 3)
        if self.stabilised.moves:
            grey = np.clip(np.round(picture), 0, 255).astype(np.uint8)
            # Far from the reference features are found from where the sampled frames have them.
            at_rest = self.stabilised.rests(frame.index)
            rough = np.eye(2, 3) if at_rest else self.stabilised.onto_near(frame.index)
            motion = motion_from(rough, self.stabilised.reference, grey, self.features)
            if motion is None:
                return None, np.empty(0)
            onto = motion
            if self.background is not None:
                onto = self.background.onto(picture, motion)
        still, _ = aligned(picture, onto)
        if frame.colour is not None:
            cb, cr = (aligned(small(one, self.stabilised.scale), onto)[0] for one in frame.colour)
            still = self.stabilised.seen(still, cb, cr)
        else:
            still = evenly(still, self.model.behind)
        seen = Sighting.of(self.rough, self.rough_scale, still, near)
        fits = self._shown(still, seen.likeliest)
        if all(fit.explained < _AS_GOOD for fit in fits):
            # The coarse raster may be farther off than a fit reaches.
            away_rad = np.array(_BESIDE_PX) / self.radius_px
            beside = np.add.outer(seen.likeliest[:1], away_rad)
            fits += self._shown(still, beside.ravel().tolist())
        if not fits:
            return None, np.empty(0)
        # A hand beside a spoke gains more than the part elsewhere, and explains no more.
        enough = _AS_GOOD * max(fit.explained for fit in fits)
        fit = next(one for one in fits if one.explained >= enough)
        return fit, seen.rivals(fit.angle_rad)

    def _shown(self, picture: Single, starts_rad: Sequence[float]) -> list[PoseFit]:
        """The fits from some angles that the picture confirms."""
        tried = (self.model.fit(picture, angle) for angle in starts_rad)
        return [fit for fit in tried if fit is not None and fit.shown]


def _some(angle_rad: Array) -> list[float]:
    """Evenly some of angles (n,): all are not needed to see where a part passes."""
    return [float(one) for one in angle_rad[:: max(1, angle_rad.size // _SOME)]]


def outline_of(found: FoundPart, stabilised: StabilisedSample) -> Array:
    """The contour (points, 2) of a part that was found, where the reference picture shows it."""
    part, scale = found.part, found.scale
    angle = Sighting.of(part, scale, stabilised.shown).most_likely
    height, width = (max(1, round(scale * side)) for side in stabilised.content.shape)
    cover = cover_in(part.view, part.cover > 0.5, angle, (height, width))
    if not cover.any():
        return np.empty((0, 2))
    return np.asarray((contour(cover) + 0.5) / scale - 0.5)


def _finer(part: TurningPart, scale: float, pivot: Array) -> tuple[PolarView, Single]:
    """The raster of a part in pictures larger by 1 / ``scale``, about a pivot, and its shape."""
    reach = min(part.view.rows * part.view.step_px, part.radius_px + 8.0 * scale) / scale
    view = PolarView.around((float(pivot[0]), float(pivot[1])), reach)
    row = (view.radius_px * scale - 0.5) / 1.0
    column = np.arange(view.columns) * part.view.columns / view.columns
    x, y = np.meshgrid(column, row)
    tiled = np.hstack([part.cover, part.cover[:, :1]])
    shape = cv2.remap(tiled, x.astype(np.float32), y.astype(np.float32), cv2.INTER_LINEAR)
    return view, np.asarray(shape > 0.5, np.float32)
