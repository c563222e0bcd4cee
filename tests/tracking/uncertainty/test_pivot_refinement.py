"""The pivot by all frames together: right where the shifts are drawn, and its doubt with it."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.tracking.fit import (
    PIVOT,
    PLANE,
    Pixels,
    PolarGrid,
    PoseSensitivity,
    Sample,
    corrected_angles,
    rotation_axis,
)
from servosight.tracking.fit._rotation_axis import pose_sensitivity, turned_errors

OFF_PX = np.array([0.01, -0.004, 0.2, -0.1, 0.05, 0.08])
OWN_PX = np.array([0.002, 0.003, -0.1, 0.05, 0.03, 0.02])  # of the learnt picture
SIGMA_PX = 0.002
TURN = np.array([0.004, -0.002, 0.001, 0.006, 0.002, 0.003])  # rad/px
SWAYS = pytest.mark.parametrize("free", [PIVOT, PLANE, slice(0, 6)], ids=["pivot", "plane", "both"])


def of(free: slice, error: np.ndarray) -> np.ndarray:
    """The same with those that are held at zero."""
    only = np.zeros(6)
    only[free] = error[free]
    return only


def drawn(angle: np.ndarray, seed: int, free: slice = PIVOT) -> list[PoseSensitivity]:
    """What frames tell of a pivot or plane that is off, each with noise of its own."""
    rng = np.random.default_rng(seed)
    own = turned_errors(angle, 6)
    error = (np.eye(6) - own) @ of(free, OFF_PX) + own @ of(free, OWN_PX)
    seen = error + SIGMA_PX * rng.standard_normal(error.shape)
    weight = np.eye(6) / SIGMA_PX**2
    return [PoseSensitivity(weight, weight @ one, TURN) for one in seen]


@SWAYS
def test_pivot_and_plane_are_found_to_their_covariance(free: slice) -> None:
    """The squared error over covariance of 40 draws: chi-square of 40 for each unknown, within 4
    sigma."""
    angle = np.deg2rad(np.linspace(-20.0, 25.0, 60))
    total = 0.0
    for seed in range(40):
        found = rotation_axis(angle, drawn(angle, seed, free), free)
        assert found is not None
        error = found.error_px - OFF_PX[free]
        total += float(error @ np.linalg.solve(found.covariance, error))
    count = 40.0 * (free.stop - free.start)
    assert total == pytest.approx(count, abs=4.0 * np.sqrt(2.0 * count))


@SWAYS
def test_angles_are_told_about_the_true_hinge(free: slice) -> None:
    angle = np.deg2rad(np.linspace(-20.0, 25.0, 400))
    wrong = angle + ((np.eye(6) - turned_errors(angle, 6)) @ of(free, OFF_PX)) @ TURN
    sensitivities = drawn(angle, 1, free)
    found = rotation_axis(wrong, sensitivities, free)
    assert found is not None
    about, shared = corrected_angles(wrong, sensitivities, found, free)
    doubt = np.sqrt((shared**2).sum(1))
    error = (about - about[0]) - (angle - angle[0])
    assert np.abs(error / doubt.max()).max() < 4.0
    assert np.abs(error).max() < 0.2 * np.abs(wrong - angle).max()


def grey(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A print with known slopes, at places about the pivot, y pointing down."""
    return np.asarray(
        100.0 + 30.0 * np.sin(0.21 * x + 0.13 * y) + 20.0 * np.cos(0.17 * y - 0.1 * x)
    )


def moved(x: np.ndarray, y: np.ndarray, error: np.ndarray, farthest: float) -> np.ndarray:
    """What is seen where the print was swayed, by the map of a plane through its pivot."""
    stretch = np.array([[error[2], -error[3]], [-error[3], -error[2]]]) / farthest
    there = np.stack([x, y])
    near = 1.0 + (error[4] * x - error[5] * y) / farthest**2
    back = there - error[:2, None] - stretch @ there - there * (near - 1.0)
    return grey(back[0], back[1])


def test_a_lean_is_what_the_normal_equations_leave_of_a_sway() -> None:
    """Slopes by differences of a print moved by a thousandth of a pixel; then against all nine
    unknowns solved at once, in double precision."""
    rng = np.random.default_rng(2)
    grid = PolarGrid((60.0, 50.0), 0.0, 1.0, 0.0, 0.01, 40, 628)
    pixels = Pixels.about(grid, (100, 120))
    chosen = np.flatnonzero(pixels.radius_px[: pixels.index.size // 2] > 5.0)[::3]
    x, y = pixels.index[chosen] % 120 - 60.0, pixels.index[chosen] // 120 - 50.0
    radius, bit = np.hypot(x, y), 1e-3
    farthest = grid.largest_px
    by_x = (grey(x + bit, y) - grey(x - bit, y)) / (2 * bit)
    by_y = (grey(x, y + bit) - grey(x, y - bit)) / (2 * bit)
    value = grey(x, y).astype(np.float32)
    per_turn = (-(by_x * y - by_y * x)).astype(np.float32)
    per_px = ((by_x * x + by_y * y) / radius).astype(np.float32)
    shown = Sample(pixels, chosen, value, per_turn, per_px)
    ways = np.stack(
        [
            (moved(x, y, bit * one, farthest) - moved(x, y, -bit * one, farthest)) / (2 * bit)
            for one in np.eye(6)
        ]
    )
    seen = np.clip(value + rng.normal(0.0, 3.0, chosen.size), 0, 255).astype(np.uint8)
    weight = rng.uniform(0.5, 1.0, chosen.size).astype(np.float32)
    rows = np.stack([value, np.ones_like(value), per_turn])
    weighed = rows.astype(float) * weight
    normal = weighed @ rows.T
    solution = np.linalg.solve(normal, weighed @ seen)

    told = pose_sensitivity(shown, seen, rows, weight, normal, solution, 4.0)

    free = np.concatenate([rows, solution[0] * ways]).astype(float)
    whole = free * weight @ free.T
    inverse = np.linalg.inv(whole)
    scale = np.sqrt(np.diag(told.weight))
    left = np.linalg.inv(inverse[3:, 3:]) / 4.0
    np.testing.assert_allclose(
        told.weight / np.outer(scale, scale), left / np.outer(scale, scale), atol=5e-3
    )
    error = (inverse @ (free * weight @ (seen - solution @ rows)))[3:]
    error = np.linalg.solve(told.weight, told.right) - error
    assert np.abs(error * scale).max() < 0.05
    turn = np.linalg.solve(normal, whole[:3, 3:])[2]
    np.testing.assert_allclose(told.turn, turn, atol=5e-3 * np.abs(turn).max())


def test_too_few_frames_tell_nothing() -> None:
    assert rotation_axis(np.zeros(3), drawn(np.zeros(3), 1)) is None
