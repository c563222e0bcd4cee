"""Command signals: amplitude, frequency and seed as asked."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.models.excitation import chirp, multisine, sine, standard, steps, triangle

TIME_S = np.arange(0.0, 10.0, 0.001)


def test_steps_hold_their_levels_and_keep_the_amplitude() -> None:
    command = steps(TIME_S, 15.0, 0.5, seed=1)
    assert np.all(command[TIME_S < 0.499] == 0.0)
    assert np.abs(command).max() <= 15.0
    assert np.unique(command).size <= 20
    change = TIME_S[1:][np.diff(command) != 0.0]
    np.testing.assert_allclose(change / 0.5, np.round(change / 0.5), atol=0.003)
    levels = np.unique(command[command != 0.0])
    assert np.abs(levels).min() >= 0.2 * 15.0, "no step too small to show"


def test_seeds_repeat_and_differ() -> None:
    for shape in (
        lambda seed: steps(TIME_S, 15.0, 0.5, seed),
        lambda seed: multisine(TIME_S, 15.0, 0.5, 9.0, seed),
    ):
        np.testing.assert_array_equal(shape(1), shape(1))
        assert not np.array_equal(shape(1), shape(2))


def test_chirp_sweeps_from_low_to_high() -> None:
    """The phase's derivative: 0.5 Hz at first, 10 Hz at last, by zero crossings."""
    fine = np.arange(0.0, 10.0, 1e-5)
    wave = chirp(fine, 12.0, 0.5, 10.0)
    assert np.abs(wave).max() == pytest.approx(12.0, rel=1e-3)
    crossings = fine[1:][np.diff(np.sign(wave)) != 0]
    assert crossings[1] - crossings[0] == pytest.approx(1.0, rel=0.4)
    assert 0.5 / (crossings[-1] - crossings[-2]) == pytest.approx(10.0, rel=0.03)
    assert wave[0] == 0.0


def test_triangle_and_sine() -> None:
    """Slope of a triangle: four amplitudes a period."""
    wave = triangle(TIME_S, 10.0, 0.5)
    assert np.abs(wave).max() == pytest.approx(10.0, rel=1e-3)
    assert np.median(np.abs(np.diff(wave))) / 0.001 == pytest.approx(4 * 10.0 * 0.5, rel=1e-6)
    assert wave[0] == 0.0
    assert wave[1] > 0.0
    np.testing.assert_allclose(sine(TIME_S, 20.0, 1.0), 20.0 * np.sin(2 * np.pi * TIME_S))


def test_multisine_holds_odd_harmonics_of_equal_size() -> None:
    """Even harmonics stay free: what appears there in an answer is nonlinear."""
    wave = multisine(TIME_S, 10.0, 0.5, 9.0, seed=3)
    assert np.abs(wave).max() == pytest.approx(10.0)
    assert wave[0] == 0.0
    spectrum = np.abs(np.fft.rfft(wave)) / TIME_S.size
    odd = spectrum[5 * np.arange(1, 19, 2)]
    np.testing.assert_allclose(odd, odd[0], rtol=1e-6)
    assert spectrum[5 * np.arange(2, 19, 2)].max() < 1e-9 * odd[0]


def test_standard_shows_rest_steps_slow_turns_and_speed() -> None:
    """Rows at the sender's rate, at rest first, within the amplitude, reversals at two sizes."""
    command = standard(20.0, 20.0, seed=2, rate_hz=250.0)
    assert command.duration_s == pytest.approx(20.0)
    np.testing.assert_allclose(np.diff(command.time_s), 0.004)
    assert np.all(command.command_deg[command.time_s < 0.35] == 0.0)
    assert np.abs(command.command_deg).max() <= 20.0 + 1e-9
    again = standard(20.0, 20.0, seed=2, rate_hz=250.0)
    np.testing.assert_array_equal(command.command_deg, again.command_deg)
    assert np.abs(np.diff(command.command_deg)).max() > 4.0, "steps"
    large, small = (
        np.ptp(command.command_deg[(command.time_s > low) & (command.time_s < high)])
        for low, high in ((11.5, 13.5), (14.4, 15.8))
    )
    assert large == pytest.approx(30.0, rel=0.05)
    assert small == pytest.approx(6.0, rel=0.05)
