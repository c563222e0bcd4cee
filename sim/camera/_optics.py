"""From light to grey levels: what lens, sensor and converter do, as functions on arrays.

The order is that of a real camera: light is summed linearly over the exposure (``_compose.py``),
then blurred by the lens, dimmed towards the corners, averaged by each pixel, turned into electrons
with shot noise, read with noise and a fixed pattern, amplified, clipped, quantized, and only then
encoded with a gamma.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Annotated

import cv2
import numpy as np
from numba import njit

from servosight.models.core import Image, Single, within


@dataclass(frozen=True)
class Optics:
    """Lens and sensor. Grey levels are those of the converter, 0 to 255.

    ``white_level``: grey level of a white sheet; the lamp is set for it at any exposure time.
    ``gain``: grey levels per electron (K of EMVA 1288), 0.03 for a full well of 8,500 electrons.
    ``read_noise_e``: electrons. ``pixel_gain_rms`` (PRNU) and ``pixel_offset_rms`` [grey levels]
    (DSNU) are the fixed pattern. ``blur_px``: rms width of the lens's blur, a Gaussian;
    ``defocus_px``: radius of the disc that a point out of focus becomes. ``vignetting``: share
    of the light lost at the picture's half width from the optical axis. The defaults give a noise
    of about 2 grey levels in mid grey.
    """

    white_level: Annotated[float, within(0.0, 1e3, "grey levels")] = 235.0
    dark_level: Annotated[float, within(0.0, 1e3, "grey levels, less than white_level")] = 4.0
    gain: Annotated[float, within(0.0, 10.0, "grey levels an electron")] = 0.03
    read_noise_e: Annotated[float, within(0.0, 1e4, "electrons")] = 25.0
    pixel_gain_rms: Annotated[float, within(0.0, 0.2, "of the signal")] = 0.005
    pixel_offset_rms: Annotated[float, within(0.0, 50.0, "grey levels")] = 0.3
    blur_px: Annotated[float, within(0.0, 10.0, "pixels")] = 0.6
    defocus_px: Annotated[float, within(0.0, 20.0, "pixels")] = 0.0
    vignetting: Annotated[float, within(0.0, 0.9, "of the light")] = 0.08
    gamma: Annotated[float, within(0.2, 5.0, "")] = 1.0

    @property
    def margin_px(self) -> int:
        """Pixels beyond the picture whose light the lens may bring into it."""
        return math.ceil(4.0 * self.blur_px) + math.ceil(self.defocus_px)

    @property
    def clean(self) -> Optics:
        """The same camera without any noise; 8 bits remain."""
        return replace(self, gain=0.0, read_noise_e=0.0, pixel_gain_rms=0.0, pixel_offset_rms=0.0)


@dataclass(frozen=True)
class FixedPattern:
    """Each pixel's relative gain and its offset [grey levels]; (height, width) float32."""

    gain: Single
    offset: Single


def fixed_pattern(optics: Optics, height: int, width: int, seed: int) -> FixedPattern:
    """Draw the sensor that belongs to ``seed``."""
    rng = np.random.default_rng([seed, 101])
    gain, offset = rng.standard_normal((2, height, width), dtype=np.float32)
    return FixedPattern(
        np.float32(1.0) + np.float32(optics.pixel_gain_rms) * gain,
        np.float32(optics.pixel_offset_rms) * offset,
    )


def blur_and_bin(light: Single, optics: Optics, factor: int, margin: int) -> Single:
    """Blur by the lens, then average over square pixels of ``factor`` x ``factor`` samples.

    ``light`` (rows, columns) has ``margin`` pixels more on each side than the result, at least
    ``optics.margin_px``. Blurring at the finer grid, before the sensor samples, is what keeps the
    result free of aliasing.
    """
    if optics.margin_px > margin:
        raise ValueError(f"expected a margin of {optics.margin_px} px or more, got {margin}")
    if optics.defocus_px > 0.0:
        light = np.asarray(cv2.filter2D(light, -1, disc(optics.defocus_px * factor)))
    if optics.blur_px > 0.0:
        side = 2 * math.ceil(4.0 * optics.blur_px * factor) + 1
        light = np.asarray(cv2.GaussianBlur(light, (side, side), optics.blur_px * factor))
    edge = margin * factor
    rows, columns = (n // factor - 2 * margin for n in light.shape)
    core = light[edge : edge + rows * factor, edge : edge + columns * factor]
    total = np.zeros((rows, columns), dtype=np.float32)
    for j in range(factor):
        for i in range(factor):
            total += core[j::factor, i::factor]
    return np.asarray(total / factor**2, dtype=np.float32)


def disc(radius: float) -> Single:
    """A pillbox of ``radius`` samples that sums to one, each sample by the share it covers."""
    reach, fine = math.ceil(radius), 16
    at = (np.arange((2 * reach + 1) * fine) + 0.5) / fine - 0.5 - reach
    inside = at[None, :] ** 2 + at[:, None] ** 2 <= radius**2
    side = 2 * reach + 1
    kernel = inside.reshape(side, fine, side, fine).sum(axis=(1, 3)).astype(np.float32)
    return np.asarray(kernel / kernel.sum())


def vignette(height: int, width: int, axis_px: tuple[float, float], loss: float) -> Single:
    """Relative light over the picture, 1 on the optical axis; falls with the radius squared."""
    x = np.arange(width) - axis_px[0]
    y = np.arange(height) - axis_px[1]
    radius2 = (x[None, :] ** 2 + y[:, None] ** 2) / (0.5 * width) ** 2
    return (1.0 / (1.0 + loss / (1.0 - loss) * radius2)).astype(np.float32)


def sensor_of(optics: Optics) -> Single:
    """What the converter's loop needs: white over dark, dark, gain, variance of the reading."""
    white, dark, gain = optics.white_level - optics.dark_level, optics.dark_level, optics.gain
    return np.array([white, dark, gain, (gain * optics.read_noise_e) ** 2], dtype=np.float32)


@njit(cache=True, nogil=True)
def variance(mean, sensor):  # type: ignore[no-untyped-def]
    """Temporal variance [grey levels^2] before quantization, EMVA 1288 release 4, eq. (17).

    var = K^2 sigma_d^2 + K (mean - dark); quantization adds 1/12. ``mean`` is a number or an array.
    """
    return np.maximum(mean - sensor[1], np.float32(0.0)) * sensor[2] + sensor[3]


@njit(cache=True, nogil=True)
def _convert(level, gain, offset, grain, sensor):  # type: ignore[no-untyped-def]
    """From light to grey levels, in place in ``level``; all (height, width) float32.

    One loop: whole arrays for each step take three times as long.
    """
    for j in range(level.shape[0]):
        for i in range(level.shape[1]):
            mean = sensor[0] * level[j, i] * gain[j, i] + sensor[1]
            noisy = mean + grain[j, i] * np.sqrt(variance(mean, sensor))
            level[j, i] = noisy + offset[j, i]


def expose(light: Single, optics: Optics, pattern: FixedPattern, rng: np.random.Generator) -> Image:
    """One picture of ``light`` (height, width), where 1 is white; uint8.

    Shot noise is drawn from a Gaussian of the Poisson variance: at 100 electrons and more, where
    all of a lit picture lies, the two agree within a tenth of a grey level.
    """
    if optics.gain > 0.0:
        grain = rng.standard_normal(light.shape, dtype=np.float32)
    else:
        grain = np.zeros(light.shape, dtype=np.float32)
    level = light.astype(np.float32, order="C")
    _convert(level, pattern.gain, pattern.offset, grain, sensor_of(optics))
    return encode(level, optics.gamma)


def encode(level: Single, gamma: float) -> Image:
    """Clip to 0 to 255, quantize, and apply the transfer curve."""
    code = np.clip(np.rint(level), 0.0, 255.0).astype(np.uint8)
    if gamma == 1.0:
        return code
    curve = np.rint(255.0 * (np.arange(256) / 255.0) ** (1.0 / gamma)).astype(np.uint8)
    return curve[code]
