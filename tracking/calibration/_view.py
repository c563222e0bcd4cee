"""The camera's view of the surface: as calibrated, else from the swing, else along the axis.

Only the frames from which the surface is found are resampled into the plane; angles are measured
on the pictures' own pixels, whose positions in the plane are a table.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import cv2
import numpy as np

from servosight.models.core import Array, Image
from servosight.tracking.calibration._swing import Swing, calibrate_swing
from servosight.tracking.calibration._swing_features import feature_tracks
from servosight.tracking.core import (
    UNKNOWN,
    CameraGeometry,
    Features,
    MotionPlane,
    Tilt,
    like_picture,
)

_MOST_FRAMES = 16
# Features have a common error that depends on the view and that their own scatter does not show: on
# the twin's videos at 30 deg off the axis the error was up to 2.8 times the sigma from the scatter.
_VIEW_FACTOR = 3.0
_CODED_PX = 0.3  # error of a feature that lasts for frames, in codecs that predict


@dataclass(frozen=True)
class CameraView:
    """The plane that the tracker works in, the swing from which it was found, a sentence on it, and
    the camera's tilt.

    ``calibrated`` says that a calibration gave it, ``doubtful`` that the swing's plane is neither
    used nor excluded.
    """

    plane: MotionPlane
    swing: Swing | None
    note: str
    tilt: Tilt = UNKNOWN
    calibrated: bool = False
    doubtful: bool = False

    @property
    def found(self) -> bool:
        """Whether the plane is the one found from the swing."""
        return self.swing is not None and self.plane is self.swing.plane

    def shared_rad(self, angle_rad: Array) -> Array:
        """Errors of angles (n,) relative to the first frame's due to the plane; (n, errors).

        One sigma of each independent error."""
        if self.swing is not None and self.doubtful:
            return _correction(self.swing, angle_rad)[:, None]
        if self.swing is None or not self.found:
            return np.zeros((len(angle_rad), 0))
        return _VIEW_FACTOR * self.swing.shared_at(angle_rad)


def view_of(
    images: Sequence[Image],
    camera: CameraGeometry | None = None,
    predicted: bool = False,
    features: Features | None = None,
) -> CameraView:
    """The view from frames spread over the motion, the first frame first.

    ``predicted`` says that the codec predicts pictures from earlier ones: an error of a feature
    then lasts for frames, and a tilt that moves features by less is not believed. ``features`` are
    the pictures', where others ask for them as well.
    """
    lens = camera.lens if camera is not None else None
    if camera is not None and camera.onto is not None:
        middle = 0.5 * (np.array(images[0].shape[1::-1], np.float64) - 1.0)
        plane = MotionPlane(like_picture(camera.onto, middle), lens)
        tilt = Tilt(tilt_deg=plane.tilt_deg(middle))
        return CameraView(plane, None, "view as calibrated", tilt, calibrated=True)
    stride = -(-len(images) // _MOST_FRAMES)
    tracks = feature_tracks(images[::stride], features or Features.of_change(images))
    swing = calibrate_swing(tracks, lens) if tracks is not None else None
    flat = MotionPlane(lens=lens)
    if swing is None:
        return CameraView(
            flat,
            None,
            "the swing is too small to show whether the camera looks along the axis of rotation: "
            "measured as if it did; `servosight calibrate` measures it",
        )
    doubt_deg = float(np.rad2deg(swing.doubt_rad.max()))
    gain_deg = float(np.rad2deg(swing.gain_rad))
    if not swing.significant:
        return CameraView(
            flat,
            swing,
            f"camera assumed to look along the axis of rotation: the swing shows no tilt, and one "
            f"too small to show changes the angle by at most {doubt_deg:.2g} deg (one sigma)",
            Tilt(sigma_deg=doubt_deg),
        )
    assert tracks is not None
    arm_px = float(np.median(np.hypot(*(tracks.xy_px - np.array(swing.pivot_px)).T)))
    if predicted and swing.gain_rad * arm_px < _CODED_PX:
        return CameraView(
            flat,
            swing,
            "camera assumed to look along the axis of rotation: the swing shows a tilt that "
            f"changes the angle by {gain_deg:.2g} deg rms, no more than the "
            "codec's errors; sigma includes it; `servosight calibrate` measures it",
            Tilt(sigma_deg=gain_deg),
            doubtful=True,
        )
    tilt_deg = swing.plane.tilt_deg(np.array(swing.pivot_px))
    return CameraView(
        swing.plane,
        swing,
        f"camera {tilt_deg:.3g} deg off the axis of rotation, found from the swing and corrected: "
        f"without that angles would be wrong by {gain_deg:.2g} deg rms",
        Tilt(tilt_deg=tilt_deg, corrected_deg=gain_deg, sigma_deg=_VIEW_FACTOR * doubt_deg),
    )


def _correction(swing: Swing, angle_rad: Array) -> Array:
    """By how much a swing's plane changes angles (n,) relative to the first frame's; (n,)."""
    order = np.argsort(swing.angle_rad)
    known, change = swing.angle_rad[order], (swing.angle_rad - swing.rigid_rad)[order]
    return np.asarray(np.interp(angle_rad, known, change) - np.interp(0.0, known, change))


def rectifier(plane: MotionPlane, shape: tuple[int, ...]) -> Callable[[Image], Image]:
    """Resamples pictures of ``shape`` (height, width) into the plane, in the same size."""
    if plane.is_picture:
        return lambda image: image
    y, x = np.indices(shape)
    seen = plane.to_picture(np.column_stack([x.ravel(), y.ravel()]).astype(np.float64))
    places = seen.T.reshape(2, *shape).astype(np.float32)

    def resampled(image: Image) -> Image:
        border = cv2.BORDER_REPLICATE
        found = cv2.remap(image, places[0], places[1], cv2.INTER_LANCZOS4, borderMode=border)
        return np.asarray(found, np.uint8)

    return resampled
