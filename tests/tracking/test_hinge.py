"""The pivot by all frames together: right where the shifts are drawn, and its doubt with it."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.tracking.hinge import Lean, hinge, lean, mended
from servosight.tracking.polar import Grid, Pixels, Sample
from servosight.tracking.rotation import turning

OFF_PX = np.array([0.01, -0.004])
OWN_PX = np.array([0.002, 0.003])  # of the learnt picture
SIGMA_PX = 0.002
TURN = np.array([0.004, -0.002])  # rad/px


def drawn(angle: np.ndarray, seed: int) -> list[Lean]:
    """What frames tell of a pivot that is off, each with noise of its own."""
    rng = np.random.default_rng(seed)
    turns = turning(angle)
    shift = (np.eye(2) - turns) @ OFF_PX + turns @ OWN_PX
    seen = shift + SIGMA_PX * rng.standard_normal(shift.shape)
    weight = np.eye(2) / SIGMA_PX**2
    return [Lean(weight, weight @ one, TURN) for one in seen]


def test_pivot_is_found_to_its_covariance() -> None:
    """The squared error over covariance of 40 draws: chi-square of 2 x 40, within 4 sigma."""
    angle = np.deg2rad(np.linspace(-20.0, 25.0, 60))
    total = 0.0
    for seed in range(40):
        found = hinge(angle, drawn(angle, seed))
        assert found is not None
        error = found.shift_px - OFF_PX
        total += float(error @ np.linalg.solve(found.covariance, error))
    assert total == pytest.approx(80.0, abs=4.0 * np.sqrt(160.0))


def test_angles_are_told_about_the_true_pivot() -> None:
    angle = np.deg2rad(np.linspace(-20.0, 25.0, 400))
    wrong = angle + ((np.eye(2) - turning(angle)) @ OFF_PX) @ TURN
    leans = drawn(angle, 1)
    found = hinge(wrong, leans)
    assert found is not None
    about, shared = mended(wrong, leans, found)
    doubt = np.hypot(*shared.T)
    error = (about - about[0]) - (angle - angle[0])
    assert np.abs(error / doubt.max()).max() < 4.0
    assert np.abs(error).max() < 0.2 * np.abs(wrong - angle).max()


def test_a_lean_is_what_the_normal_equations_leave_of_a_shift() -> None:
    """Against all five unknowns solved at once, in double precision."""
    rng = np.random.default_rng(2)
    grid = Grid((60.0, 50.0), 0.0, 1.0, 0.0, 0.01, 40, 628)
    pixels = Pixels.about(grid, (100, 120))
    chosen = np.flatnonzero(pixels.radius_px[: pixels.index.size // 2] > 5.0)[::3]
    value, per_turn, per_px = rng.normal(100.0, 30.0, (3, chosen.size)).astype(np.float32)
    shown = Sample(pixels, chosen, value, per_turn, per_px)
    seen = np.clip(value + rng.normal(0.0, 3.0, chosen.size), 0, 255).astype(np.uint8)
    weight = rng.uniform(0.5, 1.0, chosen.size).astype(np.float32)
    rows = np.stack([value, np.ones_like(value), per_turn])
    weighed = rows.astype(float) * weight
    normal = weighed @ rows.T
    solution = np.linalg.solve(normal, weighed @ seen)

    told = lean(shown, seen, rows, weight, normal, solution, 4.0)

    free = np.concatenate([rows, solution[0] * np.stack(shown.per_shift)]).astype(float)
    whole = free * weight @ free.T
    inverse = np.linalg.inv(whole)
    np.testing.assert_allclose(told.weight, np.linalg.inv(inverse[3:, 3:]) / 4.0, rtol=1e-3)
    shift = (inverse @ (free * weight @ (seen - solution @ rows)))[3:]
    np.testing.assert_allclose(np.linalg.solve(told.weight, told.right), shift, rtol=1e-2)
    np.testing.assert_allclose(told.turn, np.linalg.solve(normal, whole[:3, 3:])[2], rtol=1e-3)


def test_too_few_frames_tell_nothing() -> None:
    assert hinge(np.zeros(3), drawn(np.zeros(3), 1)) is None
