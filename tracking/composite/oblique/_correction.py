"""The angles of a part as seen along its axis, from pictures taken off the axis.

The part is learnt anew in pictures that are resampled into the plane of motion, so that it shows
what is left of the tilt; that again and again until the angles do not change.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from servosight.models.core import Array, Single
from servosight.tracking.composite._rigid_check import shifting_rad, sides_apart_rad
from servosight.tracking.composite.model import CompositeModel, PoseFit
from servosight.tracking.composite.oblique._estimate import TiltEstimate, estimated_tilt, filled
from servosight.tracking.composite.oblique._plane import ExpectedTilts, in_plane, plane_matrix
from servosight.tracking.composite.oblique._poses import blurred_less, pose_sensitivity
from servosight.tracking.core import mapped, one_sigma, threaded
from servosight.tracking.fit import PoseSensitivity
from servosight.tracking.verification import PolarView

_ROUNDS, _ENOUGH_RAD = 24, np.deg2rad(0.005)
_AROUND, _BESIDE_PX = 1.3, 12.0  # times a part's reach, and px: a tilt of 45 deg stretches by 1.19
_IN_VAIN = 7  # rounds that leave no less than an earlier one: after a step too far some leave more
_FURTHER = 3.0  # rounds
_SETTLING = 5  # rounds: at first the part's picture is of another plane than its angles
_LEAST_PICTURES = 12
_SLOWEST = 0.95  # of a round's change, the next one
# By how many sigma of the mean the logarithm of the residuals' square must be smaller in the plane,
# and by how much: shadows make up to 0.06 of it without a tilt, tilts of 9 to 23 deg 0.07 to 0.5.
_SURE, _LEAST_SMALLER = 3.0, 0.04
_OTHER_CAUSES = 0.03  # by so much shadow, codec and blur may make it smaller as a tilt would
_MOST = np.log(2.0)  # of a part that rests at few angles: more than is left
# Of what the tilt changes, sigma is to be as small a share; it may be all of it, and further rounds
# are to change as little, where a tilt explains the poses.
_KNOWN, _SETTLED = 0.6, 0.1
# Times what the plane found does to the angles: a larger change has another cause, unless the plane
# explains more than half of what is left. Of tilts of 4 to 21 deg it is 1.2, of a wheel of which
# each spoke looks like the next one 11, of a shadow beside a part that turns by 3 deg 70.
_OTHERWISE = 10.0
# Of the way of the tip from frame to frame: by so much blur may change a part's pose. A needle
# whose tip fades where it is fast, which depends on its angle, was taken for one seen from 34 deg
# off the axis.
_BLUR_SHARE = 0.01


@dataclass(frozen=True)
class SampledPart:
    """A part in sampled pictures (n, height, width) with the background ``behind`` (height, width).

    ``still`` (height, width) is 1 where it lies at angle zero. It turns about ``pivot_px`` (2,) and
    reaches ``farthest_px`` from there, its raster ``reach_px``. ``grain`` is how many pixels along
    a side share one sample. The video's own pictures, of which these may be a piece, have their
    middle at ``middle_px`` (2,), and a longer side of ``longer_px``.
    """

    pictures: Single
    behind: Single
    still: Single
    pivot_px: Array
    reach_px: float
    farthest_px: float
    grain: int
    middle_px: Array
    longer_px: float


@dataclass(frozen=True)
class ObliqueView:
    """What a camera off the axis does to angles.

    ``found`` says that the pictures show the tilt, and determine it. Corrections are ``terms`` (5,)
    [rad] of a constant, cosine and sine of the angle and of twice the angle, zero if it is not.
    ``doubts`` (5, 4) [rad] are the same terms of one sigma of each error of the shape,
    ``sigma_rad`` the rms that they make of the angles, and of what angles in the plane differ by
    from those that are corrected: the spokes of a wheel are not where a picture of them all has
    them, each in another direction. ``apart_rad`` is the rms by which angles in the plane change
    where the part may also shift, ``sides_rad`` that between its halves there; ``pivot_px`` (2,)
    lies in the picture.
    """

    found: bool
    tilt_rad: float
    terms: Array
    doubts: Array
    sigma_rad: float
    apart_rad: float
    sides_rad: float
    pivot_px: Array

    def as_doubtful(self, sigma_rad: float) -> ObliqueView:
        """The same where other pictures of the part leave the tilt as doubtful as that [rad], rms:
        the larger doubt counts of one that is not found."""
        if self.found or sigma_rad <= self.sigma_rad:
            return self
        doubts = self.doubts * (sigma_rad / max(self.sigma_rad, 1e-12))
        return replace(self, doubts=doubts, sigma_rad=sigma_rad)

    def correction_rad(self, angle_rad: Array) -> Array:
        """What is added to angles (n,)."""
        return np.asarray(_harmonics(angle_rad) @ self.terms)

    def doubt_rad(self, angle_rad: Array) -> Array:
        """Change of angles (n,) with one sigma of each error, (n, 4)."""
        return np.asarray(_harmonics(angle_rad) @ self.doubts)


@dataclass(frozen=True)
class _Round:
    """The part learnt and fitted in one plane; ``left`` (n,) is the mean square of each picture's
    residuals, NaN where the part is not shown."""

    shape_px: Array
    pivot_px: Array
    model: CompositeModel
    pictures: Single
    fits: list[PoseFit | None]
    left: Array
    estimate: TiltEstimate

    @property
    def angle_rad(self) -> Array:
        """NaN where the part is not shown; (n,)."""
        return np.array([np.nan if fit is None else fit.angle_rad for fit in self.fits])


def oblique_view(part: SampledPart, angle_rad: Array, pace_rad: Array) -> ObliqueView | None:
    """By how much the camera looks at a part from off the axis, from its angles (n,) in the sampled
    pictures, NaN where it is not found, and how far it turns from frame to frame there (n,) [rad];
    None where too few pictures show it."""
    known = np.isfinite(angle_rad)
    if known.sum() < _LEAST_PICTURES:
        return None
    part, corner = _near(part)
    pictures, angle_rad, pace_rad = part.pictures[known], angle_rad[known], pace_rad[known]
    expected = ExpectedTilts.of(part.farthest_px, part.longer_px, part.pivot_px - part.middle_px)
    rounds: list[_Round] = []
    now, shape, pivot = angle_rad, np.zeros(4), part.pivot_px
    for _ in range(_ROUNDS):
        one = _round(part, pictures, now, pace_rad, shape, pivot, expected)
        if one is None:
            break
        rounds.append(one)
        after = np.where(np.isfinite(one.angle_rad), one.angle_rad, now)
        settled = len(rounds) > 2 and _spread(after - now) < _ENOUGH_RAD
        worse = len(rounds) > _SETTLING and _gain(rounds[0], one) < 0.0
        in_vain = len(rounds) > _IN_VAIN and len(rounds) - 1 - _best(rounds) >= _IN_VAIN
        if settled or worse or in_vain:
            break
        now, (shape, pivot) = after, _next(rounds)
    if len(rounds) < 2:
        return None
    view = _view(part, angle_rad, rounds)
    return replace(view, pivot_px=view.pivot_px + corner)


def _near(part: SampledPart) -> tuple[SampledPart, Array]:
    """The piece of the pictures in which a part is seen, also in another plane and about another
    pivot, and its upper left corner (2,): each round resamples all of them."""
    around_px = _AROUND * part.reach_px + _BESIDE_PX
    size = np.array(part.behind.shape[::-1])
    first = np.clip(np.floor(part.pivot_px - around_px), 0, size - 1).astype(int)
    last = np.clip(np.ceil(part.pivot_px + around_px), first + 1, size).astype(int)
    piece = np.s_[..., first[1] : last[1], first[0] : last[0]]
    near = replace(
        part, pictures=part.pictures[piece], behind=part.behind[piece], still=part.still[piece],
        pivot_px=part.pivot_px - first, middle_px=part.middle_px - first,
    )  # fmt: skip
    return near, first.astype(np.float64)


def _next(rounds: Sequence[_Round]) -> tuple[Array, Array]:
    """Shape (4,) and pivot (2,) of the next round: where the last two rounds lead if what each is
    off by goes on to shrink as it did (Anderson 1965, of one step). A part that was learnt in
    another plane shows a tenth to a third of the tilt that is left."""
    led = [np.concatenate([one.estimate.shape_px, one.pivot_px + one.estimate.pivot_step_px])
           for one in rounds[-2:]]  # fmt: skip
    off = [to - np.concatenate([one.shape_px, one.pivot_px])
           for to, one in zip(led, rounds[-2:], strict=True)]  # fmt: skip
    further = 0.0
    if len(rounds) > 1:
        less = off[0] - off[1]
        further = float(np.clip(off[1] @ less / max(float(less @ less), 1e-12), 0.0, _FURTHER))
    to = led[-1] + further * (led[-1] - led[0])
    return to[:4], to[4:]


def _round(
    part: SampledPart, pictures: Single, angle_rad: Array, pace_rad: Array, shape_px: Array,
    pivot_px: Array, expected: ExpectedTilts,
) -> _Round | None:  # fmt: skip
    """Learn and fit the part in the plane ``shape_px`` about a pivot there; None where too few
    pictures show it."""
    matrix = plane_matrix(shape_px, part.pivot_px, part.farthest_px)
    seen = np.stack(threaded(lambda picture: in_plane(picture, matrix), list(pictures)))
    place = (float(pivot_px[0]), float(pivot_px[1]))
    away_px = float(np.hypot(*(pivot_px - part.pivot_px)))
    view = PolarView.around(place, part.reach_px + away_px)
    cover = (np.nan_to_num(view.of(in_plane(part.still, matrix))) > 0.5).astype(np.float32)
    usual = in_plane(part.behind, matrix)
    model = CompositeModel.of(seen, angle_rad, place, cover, view, usual, part.grain)
    fits = [fit if fit and fit.shown else None for fit in model.fits(seen, angle_rad)]
    shown = np.flatnonzero([fit is not None for fit in fits])
    if shown.size < _LEAST_PICTURES:
        return None

    def judged(row: int) -> tuple[PoseSensitivity, float]:
        fit = fits[row]
        assert fit is not None
        rest, slopes, weight = model.left(seen[row], fit)
        pose = pose_sensitivity(model, rest, slopes, weight, fit.angle_rad, part.farthest_px)
        # Weighed as in the fit: edges show a tilt, and the median residual is that of the plain
        # surface between them.
        return pose, float((weight * rest**2).sum() / weight.sum())

    told = threaded(judged, shown.tolist())
    left = np.full(len(fits), np.nan)
    left[shown] = [square for _, square in told]
    tip_px = part.farthest_px * pace_rad[shown]
    poses = [
        blurred_less(pose, _BLUR_SHARE * px)
        for (pose, _), px in zip(told, tip_px.tolist(), strict=True)
    ]
    angles = np.array([fit.angle_rad for fit in fits if fit])
    estimate = estimated_tilt(angles, tip_px, poses, shape_px, expected)
    return _Round(shape_px, pivot_px, model, seen, fits, left, estimate)


def _view(part: SampledPart, angle_rad: Array, rounds: Sequence[_Round]) -> ObliqueView:
    best = rounds[_best(rounds)]
    known = np.isfinite(best.angle_rad)
    change = best.angle_rad[known] - angle_rad[known]
    usual, ahead = best.estimate.sigma_rad, ahead_rad([one.angle_rad for one in rounds])
    smaller = _smaller_by(rounds[0], best)
    changed = _spread(change)
    other = changed * by_other_causes(smaller)
    sigma = float(np.sqrt(usual**2 + ahead**2 + other**2))
    settled = ahead < _SETTLED * changed and smaller > 0.0
    explained = settled and filled(angle_rad) and best.estimate.explained
    least = _LEAST_SMALLER if filled(angle_rad) else _MOST
    shown = explained or (smaller > least and _gain(rounds[0], best) > _SURE)
    sure = sigma < (1.0 if explained else _KNOWN) * changed
    by_plane = changed < _OTHERWISE * best.estimate.changes_rad or smaller > _MOST
    if not (shown and sure and by_plane):
        # What is shown, but not how far it goes, may go as far again, or as usual tilts do.
        further = min(sigma, rounds[0].estimate.usual_rad) if shown else 0.0
        doubt = max(rounds[0].estimate.doubt_rad, float(np.hypot(changed, further)))
        doubts = _doubts(rounds[0], rounds[0].estimate.doubt, doubt)
        return ObliqueView(False, 0.0, np.zeros(5), doubts, doubt, np.nan, np.nan, part.pivot_px)
    matrix = plane_matrix(best.shape_px, part.pivot_px, part.farthest_px)
    terms = _terms(angle_rad[known], change)
    rest = _spread(change - _harmonics(angle_rad[known]) @ terms)
    return ObliqueView(
        True, best.estimate.tilt_rad, terms,
        _doubts(best, best.estimate.covariance, sigma), float(np.hypot(sigma, rest)),
        shifting_rad(best.model, best.pictures, best.fits), sides_apart_rad(best.fits),
        mapped(matrix, best.pivot_px[None])[0],
    )  # fmt: skip


def by_other_causes(smaller: float) -> float:
    """The share of a tilt that has another cause, one sigma, where the logarithm of the residuals'
    square is ``smaller`` by so much in its plane: residuals respond to a tilt by its square.

    Of needles with a shadow, whose thin tips tell a tilt alone, tilts that made it smaller by 0.06
    to 0.12 were wrong by 0.7 to 1 times themselves; those of other parts, by 0.3 to 1, by a tenth.

    >>> [round(by_other_causes(smaller), 2) for smaller in (0.01, 0.06, 0.3, 1.0)]
    [1.0, 0.71, 0.32, 0.17]
    """
    return float(np.sqrt(_OTHER_CAUSES / max(smaller, _OTHER_CAUSES)))


def _best(rounds: Sequence[_Round]) -> int:
    """The number of the round that leaves least, of those in a plane that is found."""
    return max(range(1, len(rounds)), key=lambda n: _smaller_by(rounds[0], rounds[n]))


def _doubts(one: _Round, square: Array, sigma_rad: float) -> Array:
    """The terms (5, 4) of what shapes with a mean square (4, 4) change, ``sigma_rad`` rms."""
    changes = one.estimate.by_shape @ one_sigma(square)
    shown = one.angle_rad[np.isfinite(one.angle_rad)]
    rms = float(np.sqrt(np.mean(np.sum(changes**2, axis=1))))
    return _terms(shown, changes) * (sigma_rad / max(rms, 1e-12))


def _terms(angle_rad: Array, change: Array) -> Array:
    """The terms (5, ...) of changes (n, ...) at angles (n,)."""
    rows = _harmonics(angle_rad)
    held = 1e-6 * angle_rad.size * np.diag([0.0, 1.0, 1.0, 1.0, 1.0])
    return np.asarray(np.linalg.solve(rows.T @ rows + held, rows.T @ change))


def ahead_rad(angles_rad: Sequence[Array]) -> float:
    """By how much further rounds would change the angles (n,) of rounds [rad], rms.

    Changes go on as the last two did. Of a part that rests at two angles they hardly decrease from
    round to round, since two angles hardly tell a tilt; sigma, of one round, does not show it.
    """
    changes = [_spread(after - before) for before, after in pairwise(angles_rad)]
    if len(changes) < 2 or changes[-1] < _ENOUGH_RAD:
        return changes[-1]
    ratio = min(changes[-1] / max(changes[-2], 1e-12), _SLOWEST)
    return float(changes[-1] * ratio / (1.0 - ratio))


def _gain(before: _Round, after: _Round) -> float:
    """By how many sigma of the mean the residuals of pictures are smaller than before."""
    smaller = _smaller(before, after)
    smaller = smaller[np.isfinite(smaller)]
    return float(smaller.mean() / max(smaller.std(), 1e-12) * np.sqrt(smaller.size))


def _smaller(before: _Round, after: _Round) -> Array:
    """The logarithm of the residuals before over those after; (n,)."""
    return np.asarray(np.log(before.left / after.left))


def _smaller_by(before: _Round, after: _Round) -> float:
    """The mean of that."""
    return float(np.nanmean(_smaller(before, after)))


def _spread(values: Array) -> float:
    return float(np.std(values[np.isfinite(values)]))


def _harmonics(angle_rad: Array) -> Array:
    return np.stack(
        [np.ones_like(angle_rad), np.cos(angle_rad), np.sin(angle_rad),
         np.cos(2.0 * angle_rad), np.sin(2.0 * angle_rad)], axis=-1,
    )  # fmt: skip
