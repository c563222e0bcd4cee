"""Where the model fails: windows, and what the servo did there, on cases made by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from servosight.diagnose.residuals import Judged, shares, worst_windows
from servosight.diagnose.residuals._where import MotionSamples, classify
from servosight.models.core import Array, Recording

Shape = Callable[[Array], Array]

RATE_HZ = 120.0


def case(command: Shape, error: Shape, duration_s: float = 6.0) -> Judged:
    """A perfect servo whose measured angle is off by ``error``."""
    rows = np.arange(0.0, duration_s, 0.004)
    time_s = np.arange(0.0, duration_s, 1 / RATE_HZ)
    predicted = command(time_s)
    recording = Recording("case", rows, command(rows), time_s, predicted + error(time_s))
    return Judged(recording, predicted, np.zeros(time_s.size, dtype=np.int8))


def triangle(t: Array) -> Array:
    """30 deg/s, turning round at 0.5 s, 1.5 s, 2.5 s, ..."""
    return np.asarray(15.0 * (2 / np.pi) * np.arcsin(np.sin(np.pi * t)))


def sine(t: Array) -> Array:
    return np.asarray(15.0 * np.sin(2 * np.pi * 0.5 * t))


def staircase(t: Array) -> Array:
    """Jumps of 10 deg at 1 s, 3 s and 5 s, at rest between."""
    return np.asarray(10.0 * np.searchsorted([1.0, 3.0, 5.0], t, side="right"), dtype=float)


def fast(t: Array) -> Array:
    """Two seconds slow, then 8 Hz."""
    return np.asarray(np.where(t < 3.0, sine(t), 5.0 * np.sin(2 * np.pi * 8.0 * t)))


def bump(*centres: float, width_s: float = 0.052) -> Shape:
    """1 deg about some instants."""
    return lambda t: np.asarray(
        sum(1.0 * (np.abs(t - centre) < width_s) for centre in centres), dtype=float
    )


@pytest.mark.parametrize(
    ("command", "centre", "what"),
    [
        (triangle, 2.5, "reversal"),
        (triangle, 2.0, "slew"),
        (sine, 1.5, "reversal"),
        (sine, 2.0, "slew"),
        (staircase, 3.1, "step"),
        (staircase, 4.2, "standstill"),
        (fast, 4.5, "high_frequency"),
    ],
)
def test_what_the_servo_was_doing(command: Shape, centre: float, what: str) -> None:
    judged = case(command, bump(centre))
    (first, *_) = worst_windows([judged])
    assert first.what == what
    assert first.start_s - 1e-9 <= centre <= first.end_s + 0.05
    assert first.share > 0.9
    assert next(iter(shares([judged]))) == what


def test_windows_are_ranked_and_do_not_overlap() -> None:
    """Twice the error holds four times the share."""
    one, two = bump(1.5), bump(4.5)
    windows = worst_windows([case(triangle, lambda t: one(t) + 2.0 * two(t))])
    assert windows[0].start_s <= 4.5 <= windows[0].end_s + 0.05
    assert windows[0].share == pytest.approx(0.8, abs=0.02)
    assert windows[1].share == pytest.approx(0.2, abs=0.02)
    for i, window in enumerate(windows):
        for other in windows[i + 1 :]:
            assert window.end_s < other.start_s or other.end_s < window.start_s


def test_no_error_has_no_window() -> None:
    assert worst_windows([case(triangle, np.zeros_like)]) == []


def test_windows_name_their_recording() -> None:
    calm = case(triangle, np.zeros_like)
    bad = case(sine, bump(2.0))
    assert len(worst_windows([calm, bad])) >= 1
    assert sum(shares([calm, bad]).values()) == pytest.approx(1.0)


def test_every_sample_has_a_kind() -> None:
    judged = case(fast, np.zeros_like)
    kinds = classify(MotionSamples.of(judged), judged.recording.time_s)
    assert set(kinds) <= {"reversal", "standstill", "slew", "step", "high_frequency"}
    at = judged.recording.time_s
    assert np.all(kinds[(at > 3.6) & (at < 5.5)] == "high_frequency")


def test_a_servo_that_never_moves_is_at_a_standstill() -> None:
    judged = case(np.zeros_like, bump(2.0))
    assert set(classify(MotionSamples.of(judged), judged.recording.time_s)) == {"standstill"}
