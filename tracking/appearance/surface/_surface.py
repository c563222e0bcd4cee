"""The picture of the moving part, learnt by averaging frames turned back about its pivot."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from servosight.models.core import Array, Image, Mask, Single
from servosight.tracking.appearance.surface._average import average, spline_of, swept
from servosight.tracking.appearance.surface._sampled import rounds, sampled
from servosight.tracking.core import STILL, Exposure, smeared, threaded, turning
from servosight.tracking.fit import (
    NONE_STALE,
    AngleFit,
    Pixels,
    PolarGrid,
    RingPixels,
    Rounds,
    Sample,
    gauss_newton,
    judged_fit,
    runs_of,
    spacing,
)

_SPACING_PX = 0.8
_KEPT_BLURS = 24
# At the outline the blur mixes surface and background; the model is of the surface alone.
_MARGIN_PX = 2.5
_ROUNDS = 5
_ROUND_FRAMES = 12
# More pixels cost time without benefit: noise is not the limit then.
_MOST_PIXELS = 12_000
_FEW_PIXELS = 1500
_LEARNT_PIXELS = 100_000  # of each frame, while pivot and angles are refined with the picture
_SETTLED_PX = 0.003


@dataclass(frozen=True)
class Surface:
    """The picture of the moving part at angle zero, and its position.

    ``coefficients`` (columns, rows) of its spline on ``grid``, ``reach`` (columns, rows) the
    columns to its edge (0 outside), ``outline_px`` (points, 2) its contour as x, y at angle zero.
    ``correlation`` and ``noise`` [grey levels] are those of the frames it was learnt from.
    """

    grid: PolarGrid
    coefficients: Single
    reach: Single
    outline_px: Array
    correlation: float
    noise: float

    @property
    def pivot_px(self) -> tuple[float, float]:
        """Centre of rotation, x and y."""
        return self.grid.pivot_px

    def pixels(self, shape: tuple[int, ...], every: int = 1) -> RingPixels:
        """The table of a picture's pixels that this surface can cover."""
        return RingPixels.about(self.grid, shape, every)

    @cached_property
    def runs(self) -> NDArray[np.intp]:
        """Row, first and last column of the runs of its cells; (runs, 3)."""
        return runs_of(self.reach.T > 0)

    @cached_property
    def cells(self) -> Single:
        """Its grey levels at the lattice's own points; (columns, rows)."""
        kernel = np.array([1.0, 4.0, 1.0]) / 6.0  # the cubic B-spline at whole numbers
        along = ndimage.correlate1d(self.coefficients, kernel, axis=0, mode="mirror")
        return np.asarray(ndimage.correlate1d(along, kernel, axis=1, mode="mirror"))

    @cached_property
    def _areas_px(self) -> Array:
        """Pixels covered by the cells that lie more than 0, 1, 2... half columns inside."""
        radius = self.grid.radius_px + self.grid.step_px * np.arange(self.grid.rows)
        cell = np.broadcast_to(radius * self.grid.step_px * self.grid.step_rad, self.reach.shape)
        inside = np.bincount(np.ceil(2 * self.reach).astype(np.intp).ravel(), cell.ravel())
        return np.asarray(np.cumsum(inside[::-1])[::-1][1:])

    def area_px(self, columns: float) -> float:
        """Pixels that it covers in a picture, less the uncertain ones at ``columns`` of blur."""
        if not self._areas_px.size:  # no cell lies inside: a part narrower than two columns
            return 0.0
        return float(np.interp(columns, np.arange(self._areas_px.size), self._areas_px, right=0))

    def few_pixels(self, shape: tuple[int, ...]) -> Pixels:
        """A table of few pixels: enough to find the surface."""
        return Pixels.about(self.grid, shape, self.few)

    @property
    def few(self) -> int:
        """One of so many pixels is enough to find the surface."""
        return 1 + int(self.area_px(0.0) / _FEW_PIXELS)

    @property
    def thinning(self) -> int:
        """One of so many pixels is enough to measure the angle."""
        return 1 + int(self.area_px(0.0) / _MOST_PIXELS)

    def learnt_from(self, images: Sequence[Image], angles_rad: Array) -> Surface:
        """The same surface with the picture that these frames show at their angles (frames,)."""
        splines = np.stack(threaded(spline_of, images))
        still = np.zeros((len(images), 2))
        mean = average(splines, angles_rad, still, self.grid, self.reach > 0)
        return replace(self, coefficients=mean)

    def blurred(self, smear_rad: float) -> BlurredSurface:
        """The same surface with the motion blur of a turn by ``smear_rad`` during the exposure."""
        columns = abs(smear_rad) / self.grid.step_rad
        coefficients = self.coefficients if columns < 0.2 else self._smeared(columns)
        return BlurredSurface(self, coefficients, columns)

    @cached_property
    def _smeared(self) -> Callable[[float], Single]:
        """The spline with a blur [columns]: a few are kept, as frames are fitted again with
        another shear."""
        return lru_cache(_KEPT_BLURS)(partial(smeared, self.coefficients))


@dataclass(frozen=True)
class BlurredSurface:
    """A surface with the motion blur of one exposure."""

    surface: Surface
    coefficients: Single
    columns: float

    def at(
        self, pixels: RingPixels, angle_rad: float, exposure: Exposure = STILL,
        stale: Mask = NONE_STALE,
    ) -> Sample:  # fmt: skip
        """The model at the pixels that the surface covers with certainty at this angle, without
        those that are ``stale``."""
        own = self.surface
        return sampled(
            own.grid, self.coefficients, own.reach, own.runs, pixels, angle_rad, exposure, stale
        )

    def rounds(
        self, pixels: RingPixels, exposure: Exposure = STILL, stale: Mask = NONE_STALE,
        shifted: bool = False,
    ) -> Rounds:  # fmt: skip
        """The steps of a fit of it to the pixels that ``at`` gives, its shift free if
        ``shifted``."""
        own = self.surface
        return rounds(
            own.grid, self.coefficients, own.reach, own.runs, pixels, exposure, stale, shifted
        )


def lattice(
    pivot_px: tuple[float, float], largest_px: float, mask: Mask, grid: PolarGrid
) -> PolarGrid:
    """The fine lattice about ``pivot_px`` that covers the true cells of ``mask`` on ``grid``."""
    rows = np.flatnonzero(mask.any(1))
    # A round hub carries little information: the columns are those of the part further out.
    columns = np.flatnonzero(mask[int(0.3 * rows[-1]) :].any(0))
    first = max(grid.radius_px + (rows[0] - 2) * grid.step_px, 2.0)
    last = min(grid.radius_px + (rows[-1] + 2) * grid.step_px, largest_px)
    space = spacing(_SPACING_PX, last)
    step = space / last
    low = grid.phi_rad + (columns[0] - 2) * grid.step_rad
    high = grid.phi_rad + (columns[-1] + 2) * grid.step_rad
    return PolarGrid(
        pivot_px,
        first,
        space,
        low,
        step,
        int((last - first) / space) + 1,
        int((high - low) / step) + 1,
    )


def on_grid(mask: Mask, old: PolarGrid, new: PolarGrid) -> Mask:
    """The mask of one lattice on another, nearest cell; outside it is false."""
    r = new.radius_px + new.step_px * np.arange(new.rows)
    phi = new.phi_rad + new.step_rad * np.arange(new.columns)
    j = np.rint((r - old.radius_px) / old.step_px).astype(int)
    m = np.rint((phi - old.phi_rad) / old.step_rad).astype(int)
    inside = ((j >= 0) & (j < old.rows))[:, None] & ((m >= 0) & (m < old.columns))[None, :]
    picked = mask[np.clip(j, 0, old.rows - 1)[:, None], np.clip(m, 0, old.columns - 1)[None, :]]
    return np.asarray(picked & inside)


def edge_distance(mask: Mask, grid: PolarGrid) -> Single:
    """Columns from each cell to the edge less the margin, 0 outside; (columns, rows) float32."""
    padded = np.pad(mask, 1)
    # In pixels a column is as wide as its radius makes it: measured on the cells of the last row,
    # it errs on the safe side nearer the pivot.
    margin = _MARGIN_PX / _SPACING_PX
    eroded = ndimage.distance_transform_edt(padded) > margin
    reach = np.zeros(eroded.shape, np.float32)
    left = np.zeros(eroded.shape[0], np.float32)
    right = np.zeros(eroded.shape[0], np.float32)
    for column in range(eroded.shape[1]):
        left = np.where(eroded[:, column], left + 1, 0)
        reach[:, column] = left
    for column in reversed(range(eroded.shape[1])):
        right = np.where(eroded[:, column], right + 1, 0)
        reach[:, column] = np.minimum(reach[:, column], right)
    return np.ascontiguousarray(reach[1:-1, 1:-1].T)


def outline(mask: Mask, grid: PolarGrid) -> Array:
    """The largest contour of a mask on the lattice as points x, y [px] at angle zero."""
    half = int(np.ceil(grid.largest_px)) + 2
    y, x = np.indices((2 * half + 1, 2 * half + 1)) - half
    r = (np.hypot(x, y) - grid.radius_px) / grid.step_px
    turned = np.mod(np.arctan2(-y, x) - grid.middle_rad + np.pi, 2 * np.pi) - np.pi
    m = (turned + grid.middle_rad - grid.phi_rad) / grid.step_rad
    raster = cv2.remap(
        mask.astype(np.uint8), m.astype(np.float32), r.astype(np.float32), cv2.INTER_NEAREST
    )
    contours, _ = cv2.findContours(raster, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    largest = max(contours, key=cv2.contourArea)
    smooth = cv2.approxPolyDP(largest, 0.7, True)[:, 0, :]
    return np.asarray(smooth + np.array(grid.pivot_px) - half, dtype=np.float64)


def spread(angles_rad: Array, count: int) -> NDArray[np.intp]:
    """At most ``count`` of the frames, evenly by the order of their angles."""
    order = np.argsort(angles_rad)
    places = np.linspace(0, order.size - 1, min(count, order.size))
    return np.asarray(np.sort(order[np.round(places).astype(np.intp)]))


def single(image: Image, mask: Mask, grid: PolarGrid) -> Surface:
    """The surface as one frame shows it, with its angle at zero."""
    fine = lattice(grid.pivot_px, grid.largest_px, mask, grid)
    reach = edge_distance(on_grid(mask, grid, fine), fine)
    picture = average(spline_of(image)[None], np.zeros(1), np.zeros((1, 2)), fine, reach > 0)
    return Surface(fine, picture, reach, np.empty((0, 2)), 1.0, 1.0)


def learn(
    images: Sequence[Image], angles_rad: Array, mask: Mask, grid: PolarGrid
) -> tuple[Surface, Array]:
    """Average the frames to the surface's picture, and refine angles and pivot at the same time.

    Every round fits each frame with its own shift; the shifts of a wrong pivot p - q grow with
    the turn, ``(1 - R) (p - q)``, which gives the pivot by least squares. Frames that fit badly
    (blurred by motion, covered) are left out of the average. Returns the surface and the frames'
    angles [rad], NaN where left out; all are where no frame shows what they have in common.
    """
    part = swept(grid, mask, angles_rad, images[0].shape)
    splines = np.stack(threaded(spline_of, [image[part] for image in images]))
    corner = np.array([part[1].start, part[0].start])
    angles = angles_rad.copy()
    shifts = np.zeros((len(images), 2))
    used = np.ones(len(images), bool)
    pivot = np.array(grid.pivot_px)
    fine = lattice(grid.pivot_px, grid.largest_px, mask, grid)
    reach = edge_distance(on_grid(mask, grid, fine), fine)
    for _ in range(_ROUNDS):
        fine = replace(fine, pivot_px=(float(pivot[0]), float(pivot[1])))
        chosen = np.flatnonzero(used)
        chosen = chosen[spread(angles[chosen], _ROUND_FRAMES)]
        mean = average(splines[chosen], angles[chosen], shifts[chosen] - corner, fine, reach > 0)
        surface = Surface(fine, mean, reach, np.empty((0, 2)), 0.0, 0.0)
        fits = _fits(surface, images, angles)
        used = _trusted(fits)
        if not used.any():
            return surface, np.full(len(images), np.nan)
        angles = np.array(
            [fit.angle_rad if fit else a for fit, a in zip(fits, angles, strict=True)]
        )
        shifts = np.array([fit.shift_px if fit else (0.0, 0.0) for fit in fits])
        if used.sum() >= 3:
            moved, common = pivot_error(angles[used], shifts[used])
            pivot = pivot + moved
            if float(np.hypot(*moved)) < _SETTLED_PX:
                break
            # Remove from the shifts what the new pivot explains.
            shifts = shifts - np.array([(np.eye(2) - turning(a)) @ moved for a in angles])
            shifts -= np.array([turning(a) @ common for a in angles])
    fine = replace(fine, pivot_px=(float(pivot[0]), float(pivot[1])))
    chosen = np.flatnonzero(used)
    home = np.tile(-corner, (len(chosen), 1))
    mean = average(splines[chosen], angles[chosen], home, fine, reach > 0)
    good = [fit for fit, ok in zip(fits, used, strict=True) if fit and ok]
    surface = Surface(
        fine,
        mean,
        reach,
        outline(mask, replace(grid, pivot_px=fine.pivot_px)),
        float(np.median([fit.correlation for fit in good])),
        float(np.median([fit.noise for fit in good])),
    )
    return surface, np.where(used, angles, np.nan)


def _fits(surface: Surface, images: Sequence[Image], angles_rad: Array) -> list[AngleFit | None]:
    pixels = surface.pixels(images[0].shape, 1 + int(surface.area_px(0.0) / _LEARNT_PIXELS))
    free = surface.blurred(0.0).rounds(pixels, shifted=True)

    def fitted(number: int) -> AngleFit | None:
        ended = gauss_newton(free, images[number], float(angles_rad[number]))
        return None if ended is None else judged_fit(ended)

    return threaded(fitted, range(len(images)))


def _trusted(fits: Sequence[AngleFit | None]) -> Mask:
    """The frames that fit about as well as most; at least a third of them by construction."""
    noise = np.array([fit.noise / max(fit.kept, 1e-3) if fit else np.inf for fit in fits])
    finite = noise[np.isfinite(noise)]
    if finite.size == 0:
        return np.zeros(len(fits), bool)
    return np.asarray(noise <= 1.15 * np.quantile(finite, 0.4) + 0.1)


def pivot_error(angles_rad: Array, shifts_px: Array) -> tuple[Array, Array]:
    """What to add to the assumed pivot so that the frames' shifts vanish; and their common part.

    The shift of a surface turned by R about p, seen about q: ``(1 - R) (p - q) + R c``, with c
    the average's own offset. Least squares over (frames,) angles and (frames, 2) shifts; directions
    that the turns do not determine (below a fifth of a degree) are left as they are.
    """
    rows = [np.hstack([np.eye(2) - turning(a), turning(a)]) for a in angles_rad]
    solution = np.linalg.lstsq(np.vstack(rows), shifts_px.ravel(), rcond=3e-3)[0]
    return np.asarray(solution[:2], np.float64), np.asarray(solution[2:], np.float64)
