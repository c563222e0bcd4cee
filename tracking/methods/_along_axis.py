"""A track as a camera on the axis of rotation sees it, where the part's pictures show another one.

A codec that predicts pictures, light and shadow make a part's edges uncertain by tenths of a pixel.
So where the tilt is not found, sigma holds what it may do to the angles.
"""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np

from servosight.models.core import Array
from servosight.tracking.composite import (
    TRUST,
    ObliqueView,
    SampledPart,
    evenly,
    oblique_view,
    paces_rad,
)
from servosight.tracking.core import Tilt, Track, known_median, principal
from servosight.tracking.verification import FrameSample, at_scale

_BESIDE_PX = 4.0
_SUBPIXELS = 4  # bits


def along_axis(
    track: Track, view: ObliqueView, angle_rad: Array, pivot_px: Array, assumed: str = ""
) -> Track:
    """The track corrected for a tilt that is found, about the pivot (2,) that belongs to it; with
    the tilt's sigma in any case, and among the errors that frames share.

    ``angle_rad`` (frames,) are the angles as ``view`` counts them, NaN where there is none;
    ``assumed`` is the note on the tilt so far, which one that does not show contradicts.
    """
    known = np.flatnonzero(np.isfinite(angle_rad))
    frames = np.arange(track.frames)
    seen_rad = angle_rad[known[np.clip(np.searchsorted(known, frames, "right") - 1, 0, None)]]
    sigma_deg = float(np.rad2deg(view.sigma_rad))
    doubt_deg = np.rad2deg(view.doubt_rad(seen_rad))
    doubt_deg -= doubt_deg[known].mean(0)
    # What all angles share is free: a frame's angle is known no better than most are.
    own_deg = np.maximum(np.linalg.norm(doubt_deg, axis=1), sigma_deg)
    others = [] if track.shared_deg is None else [track.shared_deg]
    track = replace(
        track,
        sigma_deg=np.where(track.found, np.hypot(track.sigma_deg, own_deg), track.sigma_deg),
        shared_deg=principal(np.hstack([*others, doubt_deg])),
    )
    if not view.found:
        tilt = replace(track.tilt, sigma_deg=sigma_deg)
        if sigma_deg <= TRUST.largest_sigma_deg:
            return replace(track, tilt=tilt)
        notes = (note for note in track.notes if note != assumed)
        return replace(track, notes=(*notes, _unknown(sigma_deg)), tilt=tilt)
    change_deg = np.rad2deg(view.correction_rad(seen_rad))
    tilt = Tilt(
        tilt_deg=float(np.rad2deg(view.tilt_rad)),
        corrected_deg=float(np.std(change_deg[known])),
        sigma_deg=sigma_deg,
    )
    note = (
        f"camera {tilt.tilt_deg:.2g} deg off the axis of rotation, found from how the "
        "part's picture changes as it turns, and corrected: without that angles would be wrong by "
        f"{tilt.corrected_deg:.2g} deg rms; what is left of it, {sigma_deg:.2g} deg (one "
        "sigma), sigma includes"
    )
    return replace(
        track,
        angle_deg=track.angle_deg + change_deg - change_deg[known[0]],
        pivot_px=(float(pivot_px[0]), float(pivot_px[1])),
        notes=(note, *track.notes),
        tilt=tilt,
    )


def seen_along_axis(
    track: Track, sample: FrameSample, outline: Array, pivot: Array, assumed: str = ""
) -> Track:
    """A track whose tilt is not calibrated, by the sampled frames in which the part is found.

    ``outline`` (points, 2) and ``pivot`` (2,) lie in the track's plane, as the pictures of the
    sample do, the outline as in the first frame; ``assumed`` as :func:`along_axis` takes it.
    """
    index, pictures, _ = sample.chosen(track.found)
    if not pictures:  # found in a few frames, between the sampled ones
        return track
    usual = known_median(np.stack(pictures))
    line, place = at_scale(outline, sample.scale), at_scale(pivot, sample.scale)
    still = np.zeros(usual.shape, np.uint8)
    corners = np.round(line * 2**_SUBPIXELS).astype(np.int32)
    cv2.fillPoly(still, [corners], 1, shift=_SUBPIXELS)
    farthest = float(np.hypot(*(line - place).T).max())
    part = SampledPart(
        np.stack([evenly(picture, usual) for picture in pictures]), usual,
        still.astype(np.float32), place, farthest + _BESIDE_PX, farthest, grain=1,
        middle_px=0.5 * (np.array(usual.shape[::-1]) - 1.0), longer_px=float(max(usual.shape)),
    )  # fmt: skip
    angle_rad = np.deg2rad(track.angle_deg)
    view = oblique_view(part, angle_rad[index], paces_rad(angle_rad)[index])
    if view is None:
        return track
    at = at_scale(view.pivot_px, 1.0 / sample.scale)
    place_px = track.plane.to_picture(at[None])[0]
    return along_axis(track, view, angle_rad, place_px, assumed)


def _unknown(sigma_deg: float) -> str:
    return (
        "all angles may be off by a tilt of the camera: the part's pictures do not show how far it "
        "looks from off the axis of rotation, which as people film changes angles by "
        f"{sigma_deg:.2g} deg (one sigma); sigma includes it; film along the axis, or `servosight "
        "calibrate` measures it, where that is too much"
    )
