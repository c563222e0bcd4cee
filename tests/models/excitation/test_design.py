"""Designed commands: within their limits, of the shape that was asked for, and plain about both."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from servosight.models.core import InputError
from servosight.models.excitation import (
    SHAPES,
    CommandLimits,
    Excitation,
    Form,
    design,
    grid_of,
    triangle,
)
from servosight.models.excitation._shapes import prbs


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("rate", [None, 300.0, 40.0])
def test_every_shape_keeps_angle_rate_and_duration(shape: str, rate: float | None) -> None:
    limits = CommandLimits(12.0, rate, 15.0, centre_deg=5.0, rows_hz=200.0)
    made = design(shape, limits, seed=4)
    rows = made.excitation
    assert rows.duration_s <= 15.0 + 1e-9
    assert rows.duration_s > 14.0
    away = np.abs(rows.command_deg - 5.0)
    assert away.max() <= 12.0 + 1e-9
    if rate is not None:
        assert np.abs(np.diff(rows.command_deg)).max() * 200.0 <= rate * (1.0 + 1e-9)
    assert away[0] <= 0.1, "starts at the centre"
    if away.max() < 0.99 * 12.0:
        assert made.notes, "what it cannot have is said"
        assert "deg/s" in made.notes[0]


def test_seeds_repeat_and_differ() -> None:
    for shape in ("steps", "prbs", "multisine", "standard"):
        one, same, other = (
            design(shape, CommandLimits(), seed=seed).excitation.command_deg for seed in (1, 1, 2)
        )
        np.testing.assert_array_equal(one, same)
        assert not np.array_equal(one, other)


def test_chirp_gives_up_amplitude_only_where_the_rate_asks_for_it() -> None:
    rows = design("chirp", CommandLimits(20.0, 300.0, 20.0)).excitation
    slow, fast = rows.time_s < 8.0, rows.time_s > 19.9
    assert np.abs(rows.command_deg[slow]).max() == pytest.approx(20.0, rel=1e-3)
    # 300 deg/s at 11.8 to 12 Hz, the last tenth of a second: 300 / (2 pi f) is 4.05 to 3.98 deg.
    assert np.abs(rows.command_deg[fast]).max() == pytest.approx(4.01, rel=0.02)


def test_multisine_leaves_even_and_some_odd_lines_empty(tmp_path: Path) -> None:
    made = design(
        "multisine", CommandLimits(20.0, 300.0, 20.0), Form(low_hz=0.4, high_hz=8.0), seed=2
    )
    made.excitation.save(tmp_path / "command.csv")
    rows = Excitation.load(tmp_path / "command.csv")
    grid = grid_of(rows.time_s, rows.command_deg)
    assert grid is not None
    assert grid.period_s == pytest.approx(5.0)
    assert grid.periods == 4
    assert np.all(grid.excited % 2 == 1)
    assert grid.excited.min() / grid.period_s >= 0.4
    assert grid.excited.max() / grid.period_s <= 8.0
    inside = grid.odd[grid.odd > grid.excited.min()]
    assert inside.size >= 4, "about one of four odd lines detects"
    spectrum = np.abs(np.fft.rfft(rows.command_deg[:1250]))
    np.testing.assert_allclose(spectrum[grid.excited], spectrum[grid.excited[0]], rtol=1e-4)
    for detecting in (grid.odd, grid.even):
        assert spectrum[detecting].max() < 1e-5 * spectrum.max()


def test_a_grid_is_seen_in_multisines_and_sines_alone() -> None:
    limits = CommandLimits(10.0, None, 12.0)
    for shape in ("steps", "chirp", "prbs", "standard", "triangle"):
        rows = design(shape, limits).excitation
        assert grid_of(rows.time_s, rows.command_deg) is None, shape
    sine = grid_of(limits.time_s, design("sine", limits).excitation.command_deg)
    assert sine is not None
    assert sine.excited.tolist() == [1]
    assert sine.odd.tolist() == [3, 5]
    # A triangle of one amplitude excites every odd line, so that none is left to detect.
    assert grid_of(limits.time_s, triangle(limits.time_s, 3.0, 0.5)) is None


def test_prbs_is_a_maximum_length_sequence() -> None:
    """127 bits: 64 of one sign, 63 of the other; circular autocorrelation -1/127 off zero."""
    time_s = np.arange(0.0, 12.8, 0.1) + 1e-6
    bits = np.sign(prbs(time_s, 3.0, 0.1, seed=5))[1:128]
    assert abs(bits.sum()) == 1.0
    for lag in range(1, 127):
        assert np.dot(bits, np.roll(bits, lag)) == -1.0
    assert np.unique(np.abs(prbs(time_s, 3.0, 0.1, seed=5))).tolist() == [0.0, 3.0]


def test_limits_read_off_a_command() -> None:
    made = design("sine", CommandLimits(20.0, None, 10.0, centre_deg=7.0), Form(frequency_hz=1.0))
    found = CommandLimits.of(made.excitation.time_s, made.excitation.command_deg)
    assert found.angle_deg == pytest.approx(20.0, rel=1e-3)
    assert found.centre_deg == pytest.approx(7.0, abs=1e-6)
    # Slope of the sine: 20 deg times 2 pi a second.
    assert found.rate_deg_s == pytest.approx(20.0 * 2.0 * np.pi, rel=1e-3)
    assert found.duration_s == pytest.approx(10.0)
    sparse = CommandLimits.of(np.array([0.0, 1.0, 2.0, 3.0]), np.array([0.0, 10.0, -10.0, 0.0]))
    assert sparse.rate_deg_s is None, "one row for each level jumps"


@pytest.mark.parametrize(
    ("shape", "limits", "form", "words"),
    [
        ("sawtooth", {}, {}, "expected one of steps"),
        ("sine", {"duration_s": 0.5}, {}, "at least 1 s"),
        ("sine", {}, {"frequency_hz": 80.0}, "a fifth of 250 rows"),
        ("sine", {}, {"frequency_hz": -1.0}, "--frequency on the command line. is -1"),
        ("sine", {}, {"low_hz": 3.0}, "is 3, expected none for the shape sine"),
        ("standard", {}, {"dwell_s": 1.0}, "only for steps and prbs"),
        ("multisine", {"duration_s": 2.0}, {}, "3 periods with 4 odd lines"),
        ("chirp", {}, {"low_hz": 5.0, "high_hz": 2.0}, "low frequency below the high"),
        ("standard", {"duration_s": 2.0}, {}, "at least 5 s"),
        ("steps", {"angle_deg": 0.0}, {}, "the angle of the command is 0 deg"),
        ("steps", {"rate_deg_s": -3.0}, {}, "the rate of the command is -3"),
        ("steps", {"duration_s": 1e9}, {}, "rows, expected 16 to"),
    ],
)
def test_what_cannot_be_had_is_one_sentence(
    shape: str, limits: dict[str, float], form: dict[str, float], words: str
) -> None:
    with pytest.raises(InputError, match=words) as raised:
        design(shape, CommandLimits(**limits), Form(**form))
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time_s,angle_deg\n0,1\n", "row 1: no column command_deg"),
        (
            "time_s,command_deg\n0,1\n0,2\n",
            "row 3: column time_s is 0 and time stands still .* expected rising time",
        ),
        (
            "time_s,command_deg\n0,nan\n1,2\n",
            "row 2: column command_deg is nan, expected a finite number",
        ),
        ("time_s,command_deg\n0,1\n1,1\n", "never moves"),
    ],
)
def test_a_command_file_that_is_none(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "command.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=words):
        Excitation.load(path)
