"""Light to grey levels: the noise law, the lens, the converter."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.sim.camera import Optics, expose, fixed_pattern, vignette
from servosight.sim.camera._optics import blur_and_bin, disc, encode, sensor_of, variance

SIDE = 400


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5, 0.9])
def test_temporal_noise_follows_emva_1288(share: float) -> None:
    """var = K^2 sigma_d^2 + K (mean - dark) + 1/12, as EMVA 1288 measures it: two pictures.

    The variance of n samples scatters by sqrt(2 / n) = 0.35 % for 160,000 pixels: 4 sigma are
    1.4 %.
    """
    optics = Optics()
    pattern = fixed_pattern(optics, SIDE, SIDE, seed=1)
    light = np.full((SIDE, SIDE), share, dtype=np.float32)
    rng = np.random.default_rng(2)
    first, second = (expose(light, optics, pattern, rng).astype(float) for _ in range(2))
    measured = 0.5 * np.var(first - second)
    mean = optics.dark_level + share * (optics.white_level - optics.dark_level)
    law = (
        (optics.gain * optics.read_noise_e) ** 2
        + optics.gain * (mean - optics.dark_level)
        + 1.0 / 12.0
    )
    assert measured == pytest.approx(law, rel=0.014)
    assert 0.5 * (first + second).mean() == pytest.approx(mean, abs=0.05)


def test_the_usual_noise_is_two_grey_levels() -> None:
    sigma = np.sqrt(variance(np.float32(115.0), sensor_of(Optics())) + 1.0 / 12.0)
    assert sigma.item() == pytest.approx(2.0, abs=0.05)


def test_the_fixed_pattern_stays_and_the_noise_does_not() -> None:
    optics = Optics()
    pattern = fixed_pattern(optics, SIDE, SIDE, seed=1)
    light = np.full((SIDE, SIDE), 0.5, dtype=np.float32)
    rng = np.random.default_rng(3)
    pictures = [expose(light, optics, pattern, rng).astype(float) for _ in range(2)]
    shared = np.cov(pictures[0].ravel(), pictures[1].ravel())[0, 1]
    signal = 0.5 * (optics.white_level - optics.dark_level)
    expected = (optics.pixel_gain_rms * signal) ** 2 + optics.pixel_offset_rms**2
    # The covariance of two pictures of variance 4.5 scatters by 4.5 / sqrt(160,000) = 0.011.
    assert shared == pytest.approx(expected, abs=0.05)


def test_a_seed_is_a_sensor_and_its_noise() -> None:
    optics = Optics()
    light = np.full((20, 30), 0.4, dtype=np.float32)

    def picture(seed: int) -> bytes:
        pattern = fixed_pattern(optics, 20, 30, seed)
        return expose(light, optics, pattern, np.random.default_rng(seed)).tobytes()

    assert picture(1) == picture(1)
    assert picture(1) != picture(2)


def test_clean_is_without_noise() -> None:
    optics = Optics().clean
    pattern = fixed_pattern(optics, 20, 30, seed=1)
    light = np.full((20, 30), 0.5, dtype=np.float32)
    picture = expose(light, optics, pattern, np.random.default_rng(0))
    assert np.unique(picture).tolist() == [round(0.5 * (optics.white_level + optics.dark_level))]


def test_clips_and_quantizes_before_the_gamma() -> None:
    level = np.array([[-3.0, 0.4, 0.6, 127.6, 300.0]], dtype=np.float32)
    assert encode(level, 1.0).tolist() == [[0, 0, 1, 128, 255]]
    # With a gamma of 2, one step of the converter at the dark end becomes sixteen.
    assert encode(level, 2.0).tolist() == [[0, 0, 16, 181, 255]]


@pytest.mark.parametrize("blur_px", [0.4, 0.6, 1.0])
def test_an_edge_keeps_its_place_and_gets_the_lens_width(blur_px: float) -> None:
    """An edge at 20.25 px, seen through lens and square pixels.

    The differences of neighbouring pixels have the edge as their mean. Their variance is blur^2,
    plus that of the pixel, plus that of the difference over a pixel; the last two are means of
    four samples here, (1 - 1/16) / 12 each. The lens is cut at four sigma: 0.11 % of its variance.
    """
    factor, margin = 4, 4
    samples = np.zeros((16 * factor, (40 + 2 * margin) * factor), dtype=np.float32)
    samples[:, round((margin + 20.75) * factor) :] = 1.0
    row = blur_and_bin(samples, Optics(blur_px=blur_px), factor, margin)[4].astype(float)
    spread = np.diff(row)
    place = np.arange(39) + 0.5
    mean = spread @ place
    assert row.size == 40
    assert mean == pytest.approx(20.25, abs=1e-4)
    box = (1.0 - 1.0 / factor**2) / 12.0
    variance_px2 = spread @ (place - mean) ** 2
    assert variance_px2 == pytest.approx(blur_px**2 + 2.0 * box, abs=0.0012 * blur_px**2 + 1e-4)


def test_blur_needs_its_margin() -> None:
    with pytest.raises(ValueError, match=r"expected a margin of 8 px or more, got 4"):
        blur_and_bin(np.zeros((40, 40), dtype=np.float32), Optics(blur_px=2.0), 2, 4)


def test_vignetting_is_round_about_the_axis() -> None:
    falloff = vignette(480, 640, (229.5, 239.5), 0.08)
    assert falloff.max() == pytest.approx(1.0, abs=1e-5)
    assert falloff[239, 549] == pytest.approx(0.92, abs=0.002)
    assert falloff[239, 229 - 150] == pytest.approx(falloff[239 - 150, 229], abs=1e-3)


def test_photon_transfer_gives_the_gain() -> None:
    """Variance against mean rises by K (EMVA 1288, eq. 24): 0.03 within 2 %.

    Variances of 160,000 pairs scatter by 0.35 %; the line runs over most of the range.
    """
    optics = Optics(pixel_gain_rms=0.0, pixel_offset_rms=0.0)
    pattern = fixed_pattern(optics, SIDE, SIDE, seed=1)
    rng = np.random.default_rng(4)
    means, variances = [], []
    for share in (0.05, 0.3, 0.55, 0.8):
        light = np.full((SIDE, SIDE), share, dtype=np.float32)
        first, second = (expose(light, optics, pattern, rng).astype(float) for _ in range(2))
        means.append(0.5 * (first + second).mean())
        variances.append(0.5 * np.var(first - second))
    slope, _ = np.polyfit(means, variances, 1)
    assert slope == pytest.approx(optics.gain, rel=0.02)


def test_defocus_is_a_disc() -> None:
    """Seen along one axis a disc of radius r has a variance of r^2 / 4."""
    kernel = disc(6.5).astype(float)
    x = np.arange(kernel.shape[0]) - kernel.shape[0] // 2
    assert kernel.sum() == pytest.approx(1.0, abs=1e-5)
    assert (kernel.sum(axis=0) @ x**2) == pytest.approx(6.5**2 / 4 + 1 / 12, rel=0.01)
    spot = np.zeros((60, 60), dtype=np.float32)
    spot[30, 30] = 1.0
    optics = Optics(blur_px=0.0, defocus_px=3.0)
    seen = blur_and_bin(spot, optics, 2, 5)
    assert seen.sum() == pytest.approx(0.25, rel=1e-4)
    assert (seen > 1e-6).any(axis=0).sum() == 7
