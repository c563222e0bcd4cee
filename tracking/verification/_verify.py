"""Is a track what the frames show? Evidence from a sample of them, and the limits on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array, Mask
from servosight.tracking.verification._pairs import pair_agreement
from servosight.tracking.verification._scene import TurningScene


@dataclass(frozen=True, kw_only=True)
class VerificationLimits:
    """What a track must reach to be returned.

    Attributes:
        least_sigmas: range of the angles, peak to peak, in sigmas; less is no motion.
        least_explained: share of the squared change, where the part passes, that the part turned
            by the angles explains and a still picture does not.
        least_share: share of the changed pixels of the picture that lie where the part passes;
            not asked of a part that the user points at.
        least_agreement: share of the frames in which a search over all angles confirms the angle.
        least_pairs: share of the pairs of frames in which what changes between the two turns by the
            difference of their angles. On eleven composed clips 0.93 to 1 for parts that turn,
            and 0.38 to 0.67 on three for people at the border who were taken for one.
        least_found: share of the frames in which the part is found.
        least_filmed: spread of the part's angles in the pictures as they were filmed, over that of
            the track's. Where the camera was thought to turn with the part, it is the background
            that turns in the stabilised pictures, and stands still in the filmed ones.
    """

    least_sigmas: float = 6.0
    least_explained: float = 0.25
    least_share: float = 0.15
    least_agreement: float = 0.7
    least_pairs: float = 0.75
    least_found: float = 0.5
    least_filmed: float = 0.5


LIMITS = VerificationLimits()

_NEAR_PX = 3.0
_NEAR_RAD = np.deg2rad(2.0)
_AS_GOOD = 0.85  # of the best gain: a part that looks the same at several angles
_TURNED_PX = 1.0
_CHANGED_SHARE, _USUAL = 0.3, 0.8


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What the frames say about a track; the names are those of ``VerificationLimits``."""

    sigmas: float
    explained: float
    share: float
    agreement: float
    pairs: float
    found: float
    filmed: float


def evidence_of(
    scene: TurningScene,
    angle_rad: Array,
    sigma_rad: Array,
    found: Mask,
    roll_rad: Array,
    elsewhere: Mask | None = None,
) -> Evidence:
    """Weigh a track, whose angles, sigmas and marks of found frames are (frames,) each.

    ``scene`` is the part as a sample of the frames shows it, ``roll_rad`` the camera's own turns in
    these, ``elsewhere`` (height, width), or of each frame, marks pixels of other moving things.
    """
    spread = float(np.ptp(np.quantile(angle_rad[found], [0.01, 0.99]))) if found.any() else 0.0
    usual = max(float(np.median(sigma_rad[found])), 1e-12) if found.any() else 1.0
    changed, inside = scene.changed(elsewhere)
    # By a quantile: of a hand that passes, most of the picture changes for some frames.
    telling = changed >= max(_CHANGED_SHARE * float(np.quantile(changed, _USUAL)), 10.0)
    share = float(np.median(inside[telling] / changed[telling])) if telling.any() else 1.0
    return Evidence(
        sigmas=spread / usual,
        explained=_explained(scene),
        share=share,
        agreement=_agreement(scene),
        pairs=pair_agreement(
            scene.view,
            scene.frames,
            scene.angle_rad,
            scene.swept,
            scene,
            _near(scene),
            _AS_GOOD,
        ),
        found=float(found.mean()),
        filmed=_filmed(scene.angle_rad, roll_rad),
    )


def _filmed(angle_rad: Array, roll_rad: Array) -> float:
    """Spread of a part's angles before the camera's turns were removed, over that after (n,)."""
    spread = float(np.std(angle_rad))
    return float(np.std(angle_rad + roll_rad)) / spread if spread > 0.0 else 1.0


def _explained(scene: TurningScene) -> float:
    """Of the half of the frames that differ most from the median frame; of a part that rests
    nearly always, of those in which it lies elsewhere."""
    model, still = scene.left_over()
    turned_px = np.abs(scene.angle_rad - np.median(scene.angle_rad)) * scene.view.radius_px[-1]
    elsewhere = turned_px > _TURNED_PX
    counted = elsewhere if elsewhere.any() else np.ones_like(elsewhere)
    telling = counted & (still >= np.median(still[counted]))
    return float(np.median(1.0 - model[telling] / np.maximum(still[telling], 1e-9)))


def _agreement(scene: TurningScene) -> float:
    """Share of frames in which the angle is the one found by a search over all angles."""
    gains, angles = scene.gains(), scene.view.angles()
    near = _near(scene)
    agreed = []
    for gain, angle in zip(gains, scene.angle_rad, strict=True):
        apart = np.abs(np.angle(np.exp(1j * (angles - angle))))
        best, here = float(gain.max()), float(gain[apart <= near].max())
        agreed.append(best > 0.0 and here >= _AS_GOOD * best)
    return float(np.mean(agreed))


def _near(scene: TurningScene) -> float:
    """How far from an angle a coarse search may find it [rad]."""
    return float(max(_NEAR_RAD, _NEAR_PX / scene.view.rows))


def contradiction(evidence: Evidence, pointed: bool) -> str | None:
    """Why the frames contradict a track, as the middle of a sentence; None where they confirm it.

    ``pointed``: the user pointed at the part, so that other things may move more.
    """
    if evidence.found < LIMITS.least_found:
        return f"the part was found in only {evidence.found:.0%} of the frames"
    if evidence.sigmas < LIMITS.least_sigmas:
        return (
            f"the part moves by only {evidence.sigmas:.2g} sigma of its angle, which is no motion"
        )
    if evidence.explained < LIMITS.least_explained:
        return (
            "the part turned by the angles found explains only "
            f"{max(evidence.explained, 0.0):.0%} of what changes where it passes"
        )
    if evidence.agreement < LIMITS.least_agreement:
        return (
            "a search over all angles confirms the angle in only "
            f"{evidence.agreement:.0%} of the frames"
        )
    if evidence.pairs < LIMITS.least_pairs:
        return (
            "what changes from frame to frame turns by the difference of the angles in only "
            f"{evidence.pairs:.0%} of the pairs"
        )
    if evidence.filmed < LIMITS.least_filmed:
        return (
            "what turns stands still in the pictures as they were filmed, so it is the background, "
            "and the part was taken to turn with the camera"
        )
    if not pointed and evidence.share < LIMITS.least_share:
        return f"the part found makes up only {evidence.share:.0%} of what moves in the picture"
    return None
