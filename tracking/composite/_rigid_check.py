"""Second measurements of the angles: without the pivot, and of both halves of the part."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.models.core import Array, Single
from servosight.tracking.composite.model import CompositeModel, PoseFit
from servosight.tracking.core import limited_rms

_LEAST_FRAMES = 10
_TELLING_RAD = np.deg2rad(0.5)  # the difference that the check is made for
_ROUNDS, _GATE = 3, 3.0
_SURE = 4.0  # times what chance gives, mean square
_FAR_OFF = 5.0  # times the median
# Of the turn. On 39 composed clips a fit that may shift turned by up to 4 % more or less where a
# part turned, by 37 % where a stick was seen in part, and thought to turn about another place.
_LEAST_SHARE, _SURE_SIGMAS = 0.15, 4.0


def shifting_rad(model: CompositeModel, pictures: Single, fits: Sequence[PoseFit | None]) -> float:
    """The rms [rad] by which the angles of pictures (n, height, width) change, beyond chance, where
    the part may also shift; ``fits`` (n,) are those without."""
    pairs = []
    for picture, fit in zip(pictures, fits, strict=True):
        free = fit and model.fit(picture, fit.angle_rad, shifted=True)
        if fit and free and free.shown:
            pairs.append((fit.angle_rad, free.angle_rad - fit.angle_rad, free.sigma_rad))
    changes = np.array(pairs).reshape(-1, 3).T
    return max(pattern_of(*changes), proportional_rad(*changes))


def proportional_rad(angle_rad: Array, difference_rad: Array, sigma_rad: Array) -> float:
    """The rms [rad] of differences (n,), as those of :func:`pattern_of`, that are a share of the
    angles (n,): of a part that slides, the angle is only as right as the distance of its pivot.

    0 where the share is small, or chance explains it. Frames that show little of the direction
    count less: many of them together tell what one does not.
    """
    if angle_rad.size < _LEAST_FRAMES:
        return 0.0
    weight = 1.0 / np.maximum(sigma_rad, 1e-9)
    turned = angle_rad - np.average(angle_rad, weights=weight**2)
    terms = np.column_stack([np.ones_like(turned), turned]) * weight[:, None]
    found, *_ = np.linalg.lstsq(terms, difference_rad * weight, rcond=None)
    left = difference_rad * weight - terms @ found
    scatter = max(1.0, float(left @ left) / (turned.size - 2))
    share = abs(float(found[1]))
    sigma = np.sqrt(scatter / max(float(terms[:, 1] @ terms[:, 1]), 1e-300))
    if share < _LEAST_SHARE or share < _SURE_SIGMAS * sigma:
        return 0.0
    return share * float(np.std(angle_rad))


def pattern_of(angle_rad: Array, difference_rad: Array, sigma_rad: Array) -> float:
    """The rms [rad] of what varies with the angle in differences (n,) at angles (n,).

    0 where chance explains it. The differences are those of a fit of turn and shift from one of the
    turn alone, which takes a pivot that is off for a change of the angle. ``sigma_rad`` (n,) are
    theirs: frames of which it is large tell nothing, as of a ball at the end of a thin rod, which
    does not show its own direction.
    """
    telling = sigma_rad < _TELLING_RAD
    angle_rad, difference_rad = angle_rad[telling], difference_rad[telling]
    if angle_rad.size < _LEAST_FRAMES:
        return 0.0
    terms = np.column_stack([np.ones_like(angle_rad), np.cos(angle_rad), np.sin(angle_rad)])
    use = np.ones(angle_rad.size, bool)
    for _ in range(_ROUNDS):
        found = np.linalg.lstsq(terms[use], difference_rad[use], rcond=None)[0]
        left = difference_rad - terms @ found
        scatter = 1.4826 * float(np.median(np.abs(left[use])))
        use = np.abs(left) <= _GATE * scatter + 1e-9
    square = float(np.var((terms @ found)[use]))
    chance = scatter**2 * (terms.shape[1] - 1) / max(int(use.sum()), 1)
    return float(np.sqrt(square - chance)) if square > _SURE * chance else 0.0


def sides_apart_rad(fits: Sequence[PoseFit | None]) -> float:
    """Error of an angle [rad] that differs from angle to angle, as of a shadow beside the part.

    It shifts one side of the part, so that both sides give angles whose difference varies; the
    error of the angle is half of that, and more where the part's picture was learnt with it: on
    composed clips with shadows one to two and a half times as much. So the whole difference counts.
    """
    sides = np.array([fit.sides_rad for fit in fits if fit is not None])
    return limited_rms(sides - np.median(sides), 0.5, _FAR_OFF)
