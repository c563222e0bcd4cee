"""Where in the picture the coded light is: the pixels whose brightness follows its pattern."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.bench.timing._decode import LightPattern
from servosight.models.core import Array, Image, Single

BLOCK_PX = 8
"""Side of the blocks of pixels over which brightness is averaged."""

_LEAST_CHANGE = 4.0  # grey levels of a block, standard deviation
_ALIKE = 0.75  # correlation with the pattern
_KEPT = 0.8  # share of the best block's correlation that its neighbours must have
_NEAR = 3  # blocks


@dataclass(frozen=True, kw_only=True)
class SeenLight:
    """The light's place x, y [px], its brightness ``level`` (frames,), and the rough offset.

    ``row`` is its height in the picture as a share, 0 at the top: under a rolling shutter it is
    exposed that share of the readout later than the first row. ``weights`` (rows, columns) are
    those of the blocks in ``level``. ``correlation`` is that with the pattern.
    """

    place_px: tuple[float, float]
    row: float
    weights: Array
    level: Array
    offset_s: float
    correlation: float


def block_means(image: Image) -> Single:
    """Mean brightness of blocks of 8 x 8 pixels, (height // 8, width // 8).

    >>> block_means(np.full((17, 16), 7, np.uint8)).tolist()
    [[7.0, 7.0], [7.0, 7.0]]
    """
    rows, columns = (n // BLOCK_PX for n in image.shape)
    whole = image[: rows * BLOCK_PX, : columns * BLOCK_PX]
    means = whole.reshape(rows, BLOCK_PX, columns, BLOCK_PX).mean(axis=(1, 3), dtype=np.float32)
    return np.asarray(means, np.float32)


def find_light(
    stamps_s: Array,
    blocks: Single,
    pattern: LightPattern,
    *,
    guess_s: float = 0.0,
    reach_s: float = 1.0,
) -> SeenLight | None:
    """The light in ``blocks`` (frames, rows, columns) of :func:`block_means`; None without one.

    ``stamps_s`` (frames,) are the frames' times on the camera's clock; the offset to the pattern's
    clock is searched for within ``reach_s`` of ``guess_s``.
    """
    count, shape = len(blocks), blocks.shape[1:]
    away = blocks.reshape(count, -1) - blocks.mean(0).reshape(1, -1)
    spread = away.std(0)
    enough = np.flatnonzero(spread > _LEAST_CHANGE)
    if enough.size == 0 or count < 2:
        return None
    frame_s = float(np.median(np.diff(stamps_s)))
    step_s = min(0.25 * pattern.bit_s, frame_s)
    offsets = guess_s + np.arange(-reach_s, reach_s + step_s, step_s)
    shares = pattern.share(stamps_s + offsets[:, None], 0.3 * frame_s)
    shares -= shares.mean(1, keepdims=True)
    size = np.maximum(np.sqrt((shares**2).mean(1, keepdims=True)), 1e-9)
    alike = (shares / size).astype(np.float32) @ away[:, enough] / (count * spread[enough])
    offset, best = np.unravel_index(int(np.argmax(alike)), alike.shape)
    most = float(alike[offset, best])
    if most < _ALIKE:
        return None
    follows = np.zeros(shape, np.float64)
    follows.flat[enough] = np.where(alike[offset] > _KEPT * most, spread[enough], 0.0)
    y, x = np.unravel_index(enough[best], shape)
    rows, columns = np.indices(shape)
    follows[np.maximum(np.abs(rows - y), np.abs(columns - x)) > _NEAR] = 0.0
    weights = follows / follows.sum()
    place = [BLOCK_PX * (float((weights * at).sum()) + 0.5) - 0.5 for at in (columns, rows)]
    return SeenLight(
        place_px=(place[0], place[1]),
        row=place[1] / (BLOCK_PX * shape[0] - 1),
        weights=weights,
        level=np.tensordot(blocks.astype(np.float64), weights, axes=2),
        offset_s=float(offsets[offset]),
        correlation=most,
    )
