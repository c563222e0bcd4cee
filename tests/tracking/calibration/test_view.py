"""The view from a swing whose correction is within what a codec leaves of a feature's place."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.models.core import Array, Image
from servosight.tracking.calibration import _view
from servosight.tracking.calibration._swing import Swing
from servosight.tracking.calibration._swing_features import Tracks
from servosight.tracking.core import MotionPlane

IMAGES: list[Image] = [np.zeros((64, 96), np.uint8)] * 8
ANGLE = np.linspace(-0.3, 0.3, 8)
ARM_PX = 20.0


def swing(gain_rad: float) -> Swing:
    """A plane off the picture, surely, whose correction of the angle has this rms."""
    change = np.cos(4.0 * ANGLE)
    change *= gain_rad / change.std()
    onto = np.eye(3)
    onto[0, 0] = 1.02
    return Swing(MotionPlane(onto), (48.0, 32.0), ANGLE, ANGLE - change, np.full((8, 4), 1e-6))


@pytest.mark.parametrize(
    ("gain_px", "predicted", "used"), [(0.29, True, False), (0.31, True, True), (0.29, False, True)]
)
def test_a_tilt_must_exceed_what_a_codec_does(
    monkeypatch: pytest.MonkeyPatch, gain_px: float, predicted: bool, used: bool
) -> None:
    """The limit is 0.3 px at the features' distance; a tilt not used is in the shared error."""
    found = swing(gain_px / ARM_PX)
    points = np.array([[48.0 + ARM_PX, 32.0]] * 8)
    tracks = Tracks(points, np.zeros(8, np.intp), np.arange(8), (64, 96))
    monkeypatch.setattr(_view, "feature_tracks", lambda images, features: tracks)
    monkeypatch.setattr(_view, "calibrate_swing", lambda tracks, lens: found)
    view = _view.view_of(IMAGES, predicted=predicted)
    assert view.found is used
    assert view.doubtful is not used
    shared: Array = view.shared_rad(ANGLE)
    if not used:
        assert shared.shape == (8, 1)
        assert np.std(shared) == pytest.approx(gain_px / ARM_PX, rel=1e-6)
        assert view.tilt.tilt_deg is None
        assert view.tilt.sigma_deg == pytest.approx(np.rad2deg(gain_px / ARM_PX), rel=1e-6)
    else:
        assert view.tilt.tilt_deg == pytest.approx(np.rad2deg(np.arccos(1 / 1.02)))
        assert view.tilt.corrected_deg == pytest.approx(np.rad2deg(gain_px / ARM_PX), rel=1e-6)
        assert np.abs(shared).max() < 1e-4
