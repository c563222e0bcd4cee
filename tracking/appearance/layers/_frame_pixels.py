"""The pixels of a frame on the layers' lattice, and the layers' model there.

The model is linear in the layers, so learning them needs two products: from layers to pixels and
back (``bent``), and the latter alone (``spread``). Both with the frame's own motion blur and row
times.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numba import njit
from numpy.typing import NDArray

from servosight.models.core import Array, Mask, Single
from servosight.tracking.core import Exposure, slopes, smeared, weights
from servosight.tracking.fit import Pixels, PolarGrid

_LEAST_SMEAR = 0.3  # columns; less is negligible


@dataclass(frozen=True)
class FramePixels:
    """The pixels of one frame that show wanted cells; (pixels,).

    ``index`` is their place in the flattened picture, ``where`` (2, pixels) the column and row of
    the lattice that they show. ``smear`` and ``parts`` (stretches,) are its exposure's, in columns.
    """

    index: NDArray[np.intp]
    where: Single
    smear: float
    parts: Single

    @classmethod
    def of(
        cls,
        pixels: Pixels,
        grid: PolarGrid,
        angle_rad: float,
        exposure: Exposure,
        wanted: NDArray[np.uint8],
    ) -> FramePixels:
        """With the surface at an angle; ``wanted`` (columns, rows) marks the cells."""
        chosen, where = covered(pixels, grid, angle_rad, exposure, wanted)
        return cls(
            pixels.index.take(chosen),
            np.ascontiguousarray(where),
            exposure.smear_rad / grid.step_rad,
            (exposure.parts_rad / grid.step_rad).astype(np.float32),
        )

    def within(self, chosen: Mask) -> FramePixels:
        """The ``chosen`` (pixels,) alone."""
        some = np.flatnonzero(chosen)
        return replace(
            self,
            index=self.index[some],
            where=np.ascontiguousarray(self.where[:, some]),
        )

    @property
    def cell(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Column and row of the nearest cell; (pixels,) each."""
        column, row = np.rint(self.where).astype(np.intp)
        return column, row

    def linear(self, layers: Single) -> Single:
        """Light and transparency (0, 1) and their slopes by column (2, 3); (4, pixels).

        ``layers`` (columns, rows, 2) are spline coefficients.
        """
        out = np.zeros((4, self.index.size), np.float32)
        _linear(self._smeared(layers), self.where, self.parts, out)
        return out

    def bent(
        self, layers: Single, behind: Single, turned: tuple[Single, Single], weight: Single,
        onto: Single,
    ) -> Array:  # fmt: skip
        """What the pixels show of the layers before the bench ``behind`` (pixels,), and of their
        ``turned`` rows (3, pixels) times numbers (3,); weighted (pixels,) and taken back.

        Added to the layers ``onto``, and, for the rows, returned (3,).
        """
        own = np.empty(3)
        shown = self._smeared(layers)
        added = onto if self.smear < _LEAST_SMEAR else np.zeros_like(onto)
        _bend(shown, self.where, self.parts, behind, *turned, weight, added, own)
        if added is not onto:
            onto += self._smeared(added)
        return own

    def spread(self, grey: Single, behind: Single, onto: Single) -> None:
        """The transpose of what the pixels show of the layers: grey levels (pixels,), added to the
        layers ``onto``."""
        if self.smear < _LEAST_SMEAR:
            _spread(onto, self.where, self.parts, behind, grey)
            return
        layers = np.zeros_like(onto)
        _spread(layers, self.where, self.parts, behind, grey)
        onto += self._smeared(layers)

    def _smeared(self, layers: Single) -> Single:
        if self.smear < _LEAST_SMEAR:
            return layers
        return smeared(layers.reshape(len(layers), -1), self.smear).reshape(layers.shape)


def covered(
    pixels: Pixels,
    grid: PolarGrid,
    angle_rad: float,
    exposure: Exposure,
    wanted: NDArray[np.uint8],
) -> tuple[NDArray[np.intp], Single]:
    """The pixels that show ``wanted`` cells (columns, rows) of a lattice turned by an angle.

    Their places in the table (pixels,), and the column and row that each shows (2, pixels).
    """
    part, turn = pixels.covering(grid, angle_rad, exposure.slack_rad)
    place, motion = (turn + grid.phi_rad, *grid.lattice[1:]), exposure.by_row
    size = part.stop - part.start
    chosen = np.empty(size + 1, np.intp)
    where = np.empty((2, size + 1), np.float32)
    count = _select(
        wanted, pixels.phi_rad[part], pixels.radius_px[part], pixels.delay[part], place, motion,
        chosen, where,
    )  # fmt: skip
    return chosen[:count] + part.start, where[:, :count]


_kernel = njit(cache=True, nogil=True, error_model="numpy", fastmath=True)


@_kernel
def _select(wanted, phi, radius, delay, place, motion, chosen, where):  # type: ignore[no-untyped-def]
    """The pixels that show wanted cells, and the columns and rows they show; returns how many."""
    columns, rows = wanted.shape
    origin, per_rad, first, per_px = place
    count = 0
    for i in range(phi.size):
        v = (radius[i] - first) * per_px
        own = (motion[0] + motion[1] * delay[i]) * delay[i]
        u = (phi[i] - origin - own) * per_rad
        inside = (v >= 1.0) & (v < rows - 2) & (u >= 1.0) & (u < columns - 2)
        m = min(max(int(u + 0.5), 0), columns - 1)
        j = min(max(int(v + 0.5), 0), rows - 1)
        # Always written, then kept or overwritten: an unpredictable branch costs more.
        chosen[count] = i
        where[0, count], where[1, count] = u, v
        count += inside & (wanted[m, j] != 0)
    return count


@_kernel
def _linear(layers, where, parts, out):  # type: ignore[no-untyped-def]
    columns, rows, _ = layers.shape
    flat = layers.reshape(-1)
    share = np.float32(1.0 / parts.size)
    for i in range(where.shape[1]):
        v = where[1, i]
        j = int(v)
        b = weights(v - np.float32(j))
        for part in parts:
            u = min(max(where[0, i] - part, np.float32(1.0)), np.float32(columns - 2.001))
            m = int(u)
            a, d = weights(u - np.float32(m)), slopes(u - np.float32(m))
            for k in range(4):
                start = 2 * ((m - 1 + k) * rows + j - 1)
                c = flat[start : start + 8]
                for side in range(2):
                    across = np.float32(0.0)
                    for n in range(4):
                        across += b[n] * c[2 * n + side]
                    out[side, i] += share * a[k] * across
                    out[2 + side, i] += share * d[k] * across


@_kernel
def _before(flat, at, b, bench):  # type: ignore[no-untyped-def]
    """Light with background along four rows from a place in the flattened layers, by weights ``b``.

    ``at`` is unsigned: for signed indices numba tests for wrap-around.
    """
    one, two, three = np.uint64(1), np.uint64(2), np.uint64(3)
    four, five, six, seven = np.uint64(4), np.uint64(5), np.uint64(6), np.uint64(7)
    light = b[0] * (flat[at] + bench * flat[at + one])
    light += b[1] * (flat[at + two] + bench * flat[at + three])
    light += b[2] * (flat[at + four] + bench * flat[at + five])
    return light + b[3] * (flat[at + six] + bench * flat[at + seven])


@_kernel
def _placed(u, part, columns, rows, row):  # type: ignore[no-untyped-def]
    """Weights of the four columns about a column ``u`` less ``part``; the first one's place in the
    flattened layers at ``row``, and the distance to the next."""
    u = min(max(u - part, np.float32(1.0)), np.float32(columns - 2.001))
    m = np.int32(u)
    stride = np.uint64(2 * rows)
    return weights(u - np.float32(m)), np.uint64(2 * ((m - 1) * rows + row)), stride


@_kernel
def _laid(flat, at, own, b, bench):  # type: ignore[no-untyped-def]
    """The transpose of ``_before``."""
    one, two, three = np.uint64(1), np.uint64(2), np.uint64(3)
    four, five, six, seven = np.uint64(4), np.uint64(5), np.uint64(6), np.uint64(7)
    through = own * bench
    flat[at] += own * b[0]
    flat[at + one] += through * b[0]
    flat[at + two] += own * b[1]
    flat[at + three] += through * b[1]
    flat[at + four] += own * b[2]
    flat[at + five] += through * b[2]
    flat[at + six] += own * b[3]
    flat[at + seven] += through * b[3]


@_kernel
def _spread(layers, where, parts, behind, grey):  # type: ignore[no-untyped-def]
    columns, rows, _ = layers.shape
    flat = layers.reshape(-1)
    share = np.float32(1.0 / parts.size)
    for i in range(where.shape[1]):
        v, bench = where[1, i], behind[i]
        j = np.int32(v)
        b = weights(v - np.float32(j))
        own = share * grey[i]
        for part in parts:
            a, at, stride = _placed(where[0, i], part, columns, rows, j - 1)
            _laid(flat, at, own * a[0], b, bench)
            _laid(flat, at + stride, own * a[1], b, bench)
            _laid(flat, at + stride + stride, own * a[2], b, bench)
            _laid(flat, at + stride + stride + stride, own * a[3], b, bench)


@_kernel
def _bend(layers, where, parts, behind, rows, own, weight, onto, by_own):  # type: ignore[no-untyped-def]
    columns, count, _ = layers.shape
    flat, out = layers.reshape(-1), onto.reshape(-1)
    share = np.float32(1.0 / parts.size)
    first = second = third = 0.0
    for i in range(where.shape[1]):
        v, bench = where[1, i], behind[i]
        j = np.int32(v)
        b = weights(v - np.float32(j))
        total = np.float32(0.0)
        for part in parts:
            a, at, stride = _placed(where[0, i], part, columns, count, j - 1)
            total += a[0] * _before(flat, at, b, bench)
            total += a[1] * _before(flat, at + stride, b, bench)
            total += a[2] * _before(flat, at + stride + stride, b, bench)
            total += a[3] * _before(flat, at + stride + stride + stride, b, bench)
        total = total * share + own[0] * rows[0, i] + own[1] * rows[1, i] + own[2] * rows[2, i]
        grey = weight[i] * total
        first, second = first + grey * rows[0, i], second + grey * rows[1, i]
        third += grey * rows[2, i]
        grey *= share
        for part in parts:
            a, at, stride = _placed(where[0, i], part, columns, count, j - 1)
            _laid(out, at, grey * a[0], b, bench)
            _laid(out, at + stride, grey * a[1], b, bench)
            _laid(out, at + stride + stride, grey * a[2], b, bench)
            _laid(out, at + stride + stride + stride, grey * a[3], b, bench)
    by_own[0], by_own[1], by_own[2] = first, second, third
