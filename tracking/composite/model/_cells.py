"""A part's cells in one picture: what is left beside the model, and the pose that leaves least.

Compiled, since every frame takes some of these passes over up to 20,000 cells.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from servosight.tracking.core import inverted, solved

_HUBER = 1.5
_REJECTED, _REJECTED_STEP = 6.0, 12.0  # of the scale, and grey levels
_ROUNDS = 6
_SETTLED_PX = 0.003  # by the farthest cell
_FARTHEST_RAD, _FARTHEST_PX = np.deg2rad(12.0), 12.0
_USUAL_SHIFT_PX = 3.0  # before the pivot is known
_BINS, _LARGEST = 4096, 256.0  # of the histogram of residuals: larger ones, in grey levels, alike
_GAUSSIAN, _LEAST_SCALE = 1.4826, 0.3
_FAR_OFF2 = 3600.0  # grey levels squared: a larger difference counts no more
_USED = 0.3  # of its area, the weight of a cell that the model explains


@njit(cache=True, nogil=True, error_model="numpy")
def residuals(  # type: ignore[no-untyped-def]
    picture, behind, pivot_px, radius_px, directions, cover, level, slopes, angle_rad, shift_px
):
    """Picture less model (cells,), its slopes by angle and shift (3, cells), the cells' areas, and
    picture less background; cells outside the picture have no area.

    The pictures (height, width) are interpolated linearly; ``directions`` (2, cells) are cosine and
    sine of the cells' at angle zero, ``slopes`` (4, cells) those of cover and level by angle, then
    by radius.
    """
    cells = radius_px.size
    left, still, area = np.empty(cells), np.empty(cells), np.empty(cells)
    rows = np.empty((3, cells))
    _residuals(
        picture, behind, pivot_px, radius_px, directions, cover, level, slopes, angle_rad, shift_px,
        left, rows, area, still,
    )  # fmt: skip
    return left, rows, area, still


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _residuals(  # type: ignore[no-untyped-def]
    picture, behind, pivot_px, radius_px, directions, cover, level, slopes, angle_rad, shift_px,
    left, rows, area, still,
):  # fmt: skip
    """As ``residuals``, into arrays that are there."""
    height, width = picture.shape
    lowest, last = height - 1.0, width - 1.0
    turn_x, turn_y = np.cos(angle_rad), np.sin(angle_rad)
    middle_x, middle_y = pivot_px[0] + shift_px[0], pivot_px[1] + shift_px[1]
    for n in range(radius_px.size):
        radius = radius_px[n]
        cos = directions[0, n] * turn_x - directions[1, n] * turn_y
        sin = directions[1, n] * turn_x + directions[0, n] * turn_y
        x, y = middle_x + radius * cos, middle_y - radius * sin
        inside = 0.0 <= x <= last and 0.0 <= y <= lowest
        area[n] = radius if inside else 0.0
        if not inside:  # nor where they are not numbers
            x, y = x if x > 0.0 else 0.0, y if y > 0.0 else 0.0
            x, y = x if x < last else last, y if y < lowest else lowest
        # Unsigned: a place below zero would be one from the end, which takes as long to rule out.
        column, row = np.uintp(min(int(x), width - 2)), np.uintp(min(int(y), height - 2))
        right, below = column + np.uintp(1), row + np.uintp(1)
        fx, fy = x - column, y - row
        one, other = picture[row, column], picture[below, column]
        one += fx * (picture[row, right] - one)
        other += fx * (picture[below, right] - other)
        seen = one + fy * (other - one)
        one, other = behind[row, column], behind[below, column]
        one += fx * (behind[row, right] - one)
        other += fx * (behind[below, right] - other)
        back = one + fy * (other - one)
        by_phi = slopes[1, n] - slopes[0, n] * back
        by_radius = slopes[3, n] - slopes[2, n] * back
        around = by_phi / max(radius, 1.0)
        rows[0, n] = by_phi
        rows[1, n] = cos * by_radius - sin * around
        rows[2, n] = -sin * by_radius - cos * around
        left[n] = seen - (1.0 - cover[n]) * back - level[n]
        still[n] = seen - back


@njit(cache=True, nogil=True, error_model="numpy")
def weights_of(left, area, scale, weight):  # type: ignore[no-untyped-def]
    """Fill in the weights (cells,) of residuals by Huber, zero where they are far too large for
    ``scale``."""
    for n in range(left.size):
        away = abs(left[n])
        own = area[n] / max(1.0, away / (_HUBER * scale))
        weight[n] = 0.0 if away >= _REJECTED * scale + _REJECTED_STEP else own


@njit(cache=True, nogil=True, error_model="numpy", fastmath={"contract"})
def _normal_equation(left, rows, weight):  # type: ignore[no-untyped-def]
    """The normal matrix (3, 3) and its right side (3,), summed in registers."""
    aa = ba = bb = ca = cb = cc = a_side = b_side = c_side = 0.0
    for n in range(left.size):
        a, b, c = rows[0, n], rows[1, n], rows[2, n]
        by_a, by_b, by_c = weight[n] * a, weight[n] * b, weight[n] * c
        aa, ba, bb = aa + by_a * a, ba + by_b * a, bb + by_b * b
        ca, cb, cc = ca + by_c * a, cb + by_c * b, cc + by_c * c
        a_side, b_side = a_side + by_a * left[n], b_side + by_b * left[n]
        c_side += by_c * left[n]
    matrix = np.array([[aa, ba, ca], [ba, bb, cb], [ca, cb, cc]])
    return matrix, np.array([a_side, b_side, c_side])


@njit(cache=True, nogil=True, error_model="numpy")
def _scale_of(left, count):  # type: ignore[no-untyped-def]
    """The standard deviation that the median of the residuals' sizes tells. Only those that share
    its place in a histogram ``count`` (bins,) are ordered: all would take ten times as long."""
    count[:] = 0
    fine = _BINS / _LARGEST
    for n in range(left.size):
        away = abs(left[n])
        count[int(away * fine) if away < _LARGEST else _BINS - 1] += 1
    place, below, half = 0, 0, left.size // 2
    while below + count[place] <= half:
        below += count[place]
        place += 1
    near, found = np.empty(count[place]), 0
    for n in range(left.size):
        away = abs(left[n])
        if (int(away * fine) if away < _LARGEST else _BINS - 1) == place:
            near[found] = away
            found += 1
    return _GAUSSIAN * np.partition(near, half - below)[half - below] + _LEAST_SCALE


@njit(cache=True, nogil=True, error_model="numpy")
def least_left(  # type: ignore[no-untyped-def]
    picture, behind, pivot_px, radius_px, directions, cover, level, slopes, start_rad, unknowns,
    held_px2,
):  # fmt: skip
    """Gauss-Newton from an angle, the shift free if there are three ``unknowns``.

    Of a ball at the end of a rod, turn and shift can hardly be distinguished: the shift is held by
    ``held_px2`` times the variance of the residuals, over that of a usual shift. Angle, shift and
    scale of the residuals; then, of the last round, what ``residuals`` returns, the weights and the
    normal matrix. The matrix is empty where the fit diverges.
    """
    cells = radius_px.size
    left, still, area, weight = np.empty(cells), np.empty(cells), np.empty(cells), np.empty(cells)
    rows, count = np.empty((3, cells)), np.empty(_BINS, np.int32)
    angle, shift, scale = start_rad, np.zeros(2), 0.0
    step, none = np.empty(unknowns), np.empty((0, 0))
    farthest, matrix = radius_px.max(), none
    for _ in range(_ROUNDS):
        _residuals(
            picture, behind, pivot_px, radius_px, directions, cover, level, slopes, angle, shift,
            left, rows, area, still,
        )  # fmt: skip
        scale = _scale_of(left, count)
        weights_of(left, area, scale, weight)
        matrix, side = _normal_equation(left, rows, weight)
        matrix, side = matrix[:unknowns, :unknowns].copy(), side[:unknowns]
        if not solved(matrix, side, step):
            return angle, shift, scale, left, rows, area, still, weight, none
        holding = matrix.copy()
        held = held_px2 * scale**2 / _USUAL_SHIFT_PX**2
        for i in range(1, unknowns):
            side[i] += held * shift[i - 1]
            holding[i, i] += held
        solved(holding, side, step)
        angle -= step[0]
        for i in range(1, unknowns):
            shift[i - 1] -= step[i]
        far = max(abs(shift[0]), abs(shift[1])) > _FARTHEST_PX
        if far or not abs(angle - start_rad) <= _FARTHEST_RAD:
            return angle, shift, scale, left, rows, area, still, weight, none
        if abs(step[0]) * farthest < _SETTLED_PX:
            break
    return angle, shift, scale, left, rows, area, still, weight, matrix


@njit(cache=True, nogil=True, error_model="numpy")
def pose_of(  # type: ignore[no-untyped-def]
    picture, behind, pivot_px, radius_px, directions, cover, level, slopes, block, ahead, start_rad,
    unknowns, held_px2, step_rad,
):  # fmt: skip
    """Whether the fit from an angle converged, and what ``PoseFit`` says of it, in its order.

    ``block`` (cells,) numbers the cells by their place, ``ahead`` (cells,) marks the leading ones;
    a cell is ``step_rad`` wide.
    """
    angle, shift, scale, left, rows, area, still, weight, normal = least_left(
        picture, behind, pivot_px, radius_px, directions, cover, level, slopes, start_rad, unknowns,
        held_px2,
    )  # fmt: skip
    covariance = np.zeros((3, 3))
    if normal.size == 0:
        none = 0.0
        return False, (
            angle, shift, covariance, none, none, scale, none, none, none, none, none,
        )  # fmt: skip
    turn_x, turn_y = np.cos(angle), np.sin(angle)
    score = np.zeros((unknowns, block.max() + 1))
    all_held = all_area = known = x_turn = y_turn = y_mean = 0.0
    inside = model = plain = 0.0
    pull, hold, influence = np.zeros(2), np.zeros(2), np.zeros(unknowns)
    for n in range(left.size):
        own = weight[n] * left[n]
        for a in range(unknowns):
            score[a, block[n]] += rows[a, n] * own
        turn = rows[0, n] * weight[n]
        held = rows[0, n] * turn
        all_held += held
        x_turn, y_turn = x_turn + rows[1, n] * turn, y_turn + rows[2, n] * turn
        y_mean += held * (
            pivot_px[1] - radius_px[n] * (directions[1, n] * turn_x + directions[0, n] * turn_y)
        )
        all_area += area[n] * rows[0, n] * rows[0, n]
        half = 0 if ahead[n] else 1
        pull[half] += turn * left[n]
        hold[half] += held
        if cover[n] > 0.5:
            inside += area[n]
            model += area[n] * min(left[n] * left[n], _FAR_OFF2)
            plain += area[n] * min(still[n] * still[n], _FAR_OFF2)
            known += area[n] if weight[n] > _USED * area[n] else 0.0
    inverse = np.empty_like(normal)
    inverted(normal, inverse)
    for place in range(score.shape[1]):  # White's sandwich (1980), by clusters
        for a in range(unknowns):
            influence[a] = 0.0
            for b in range(unknowns):
                influence[a] += inverse[a, b] * score[b, place]
        for a in range(unknowns):
            for b in range(unknowns):
                covariance[a, b] += influence[a] * influence[b]
    explained = 1.0 - model / max(plain, 1e-9)
    sides = pull[1] / max(hold[1], 1e-9) - pull[0] / max(hold[0], 1e-9)
    per_px = np.hypot(x_turn, y_turn) / max(all_held, 1e-9)
    per_left = np.sqrt(plain / max(all_area, 1e-9))
    return True, (
        angle, shift, covariance, known / max(inside, 1e-9), explained, scale, sides, per_px,
        per_left, y_mean / max(all_held, 1e-9), step_rad * (plain - model),
    )  # fmt: skip


@njit(cache=True, nogil=True, error_model="numpy")
def squares_of(  # type: ignore[no-untyped-def]
    picture, behind, pivot_px, radius_px, directions, cover, level, slopes, angle_rad, turn_rad,
    held_px2,
):  # fmt: skip
    """The squared residuals (cells,) of a picture fitted from an angle, large ones limited; NaN
    where it does not fit, and beyond the picture.

    As a rolling shutter shows the part that turns by ``turn_rad`` from the first row's time to the
    last one's; its angle is that at the middle row's.
    """
    if turn_rad != 0.0:
        turn_x, turn_y = np.cos(angle_rad), np.sin(angle_rad)
        late = np.empty_like(directions)
        for n in range(radius_px.size):
            cos, sin = directions[0, n], directions[1, n]
            y = pivot_px[1] - radius_px[n] * (sin * turn_x + cos * turn_y)
            own = turn_rad * (y / max(behind.shape[0] - 1, 1) - 0.5)
            late[0, n] = cos * np.cos(own) - sin * np.sin(own)
            late[1, n] = sin * np.cos(own) + cos * np.sin(own)
        directions = late
    angle, shift, _, left, rows, area, still, _, normal = least_left(
        picture, behind, pivot_px, radius_px, directions, cover, level, slopes, angle_rad, 1,
        held_px2,
    )  # fmt: skip
    if normal.size == 0:
        return np.full(radius_px.size, np.nan)
    _residuals(
        picture, behind, pivot_px, radius_px, directions, cover, level, slopes, angle, shift,
        left, rows, area, still,
    )  # fmt: skip
    for n in range(left.size):
        left[n] = min(left[n] * left[n], _FAR_OFF2) if area[n] > 0.0 else np.nan
    return left
