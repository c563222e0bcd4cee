"""The preconditioner of the layers' problem against the same by cosine transforms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import fft, ndimage

from servosight.tracking.appearance.layers._precondition import Preconditioner


@pytest.mark.parametrize("columns", [8, 61, 256])
def test_it_divides_each_wave_along_the_columns_by_its_power(columns: int) -> None:
    """Both repeat the end values, of which cosines are the waves: equal to the rounding of single
    precision, 6e-8 of the largest value times the condition of the roughest row, some 1e3."""
    rng = np.random.default_rng(2)
    layers = rng.standard_normal((columns, 40, 2)).astype(np.float32)
    scale = rng.uniform(0.5, 1.0, 40).astype(np.float32)
    finest, size = np.geomspace(1e-2, 1e3, 40), (1.0, 30.0)
    cos = np.cos(np.pi * np.arange(columns) / columns)[:, None, None]
    power = ((4.0 + 2.0 * cos) / 6.0) ** 2 + (2.0 - 2.0 * cos) ** 2 / finest[:, None]
    sheet = ndimage.spline_filter1d(layers.astype(float) * scale[:, None], axis=1)
    waves = fft.dct(sheet, axis=0, norm="ortho") / power
    sheet = ndimage.spline_filter1d(fft.idct(waves, axis=0, norm="ortho"), axis=1)
    expected = sheet * scale[:, None] / np.array(size)
    found = Preconditioner.of(columns, scale, size, finest).applied(layers)
    for side in range(2):
        largest = np.abs(expected[:, :, side]).max()
        np.testing.assert_allclose(found[:, :, side], expected[:, :, side], atol=1e-5 * largest)
