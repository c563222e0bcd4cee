"""What the user gives of a camera: checked, exposure and readout turned with the picture."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from servosight.models.core import Array, InputError
from servosight.models.io import EXPOSURE_SHARE
from servosight.tracking.core import CameraGeometry, Shutters, TrackOptions

_LONGEST_S = 10.0


def given_shutters(
    video: Path, options: TrackOptions, exposures_s: Array | None, tag_deg: int
) -> Shutters | None:
    """The given shutters; None where nothing is given.

    ``exposures_s`` (frames,) are a frames.csv's. The readout is that of the sensor's rows, which a
    tag may turn: upside down it runs upwards, sideways it is no model of the picture's rows.
    """
    exposure_s, readout_s = options.exposure_s, options.readout_s
    for name, value in (("exposure_s", exposure_s), ("readout_s", readout_s)):
        if value is not None and not (np.isfinite(value) and 0.0 <= value < _LONGEST_S):
            raise InputError(
                f"{video}: {name} is {value:g}; expected seconds from 0 to {_LONGEST_S:g}, set "
                f"camera.{name} in recording.toml to such a value."
            )
    if exposures_s is None and exposure_s is None and readout_s is None:
        return None
    every_s = exposures_s if exposures_s is not None else np.array([exposure_s or 0.0])
    if tag_deg % 180:
        return Shutters(every_s, 0.0, readout_s or 0.0)
    return Shutters(every_s, -(readout_s or 0.0) if tag_deg else readout_s or 0.0)


def check_size(video: Path, camera: CameraGeometry, shape: tuple[int, ...]) -> None:
    """Reject a calibration of pictures of another size than ``shape`` (rows, columns, ...)."""
    size = (shape[1], shape[0])
    if camera.size_px not in (None, size):
        raise InputError(
            f"{video}: the pictures have {size[0]} x {size[1]} px, and the camera was calibrated "
            f"with pictures of {camera.size_px[0]} x {camera.size_px[1]} px; expected a "
            "calibration at the video's own size, calibrate again at it."
        )


def check_interval(source: Path, exposure_s: float, every_s: float) -> None:
    """Reject an exposure (s) that is longer than most of the time between frames."""
    if exposure_s > EXPOSURE_SHARE * every_s:
        raise InputError(
            f"{source}: the frames are {every_s:.3g} s apart and their exposure is "
            f"{exposure_s:.3g} s; expected a shorter exposure, correct the times or the exposure."
        )
