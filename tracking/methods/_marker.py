"""Method ``marker``: a square marker on the moving part, ArUco or AprilTag, found by OpenCV.

The marker's centre about the pivot determines the angle far better than its own edges do. The pivot
is given, or the point from which all centres keep their distance.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from servosight.models.core import Array, FrameProgress, InputError
from servosight.tracking.calibration import CameraView, view_of
from servosight.tracking.core import (
    Flag,
    MarkerFamily,
    Track,
    TrackOptions,
    one_sigma,
    principal,
    turned,
    turning,
)
from servosight.tracking.methods._repeated import with_repeats
from servosight.tracking.uncertainty import gaps
from servosight.tracking.video import Film, frames

_FAMILIES: dict[MarkerFamily, tuple[int, ...]] = {
    "aruco": (cv2.aruco.DICT_4X4_1000, cv2.aruco.DICT_5X5_1000, cv2.aruco.DICT_6X6_1000,
              cv2.aruco.DICT_7X7_1000, cv2.aruco.DICT_ARUCO_ORIGINAL),
    "apriltag": (cv2.aruco.DICT_APRILTAG_36h11, cv2.aruco.DICT_APRILTAG_25h9,
                 cv2.aruco.DICT_APRILTAG_16h5),
}  # fmt: skip
_LEAST_SHARE = 0.3  # of the sampled frames that show it
_MOVED_PX = 2.0
_MAD = 1.4826  # standard deviation over median absolute deviation
# Sigma of a centre and of an edge's angle in the search for the pivot: edges have a common error of
# a tenth of this.
_CENTRE_PX, _EDGE_RAD = 0.03, np.deg2rad(1.0)


def marker(film: Film, options: TrackOptions, progress: FrameProgress | None = None) -> Track:
    """The angle of a marker's centre about the pivot in every frame.

    ``options.marker_family`` and ``marker_id`` name it; without a number the one that moves
    farthest is taken. Under a rolling shutter an angle belongs to the marker's own row, and so
    does its time. Sigma is the scatter of the centre's distance from the pivot over that distance.
    """
    images = film.images
    view = view_of(images, options.camera)
    detector, number = _chosen(film, options)
    stamps, corners = _detected(film, detector, number, progress)
    swing = _swing(view, corners, options.pivot)
    readout_s = film.shutters.readout_s if film.shutters is not None else 0.0
    middle_s = film.shutters.middle_s if film.shutters is not None else 0.0
    time_s = film.times(stamps, middle_s)
    row = np.where(swing.found, swing.centre_px[:, 1] / (images[0].shape[0] - 1) - 0.5, 0.0)
    flags = np.where(swing.found, Flag.NONE, Flag.LOST).astype(np.uint8)
    flags |= np.where(gaps(time_s), Flag.AFTER_GAP, Flag.NONE).astype(np.uint8)
    x, y = view.plane.to_picture(swing.pivot[None])[0]
    outline = view.plane.to_picture(swing.outline)
    low, size = outline.min(0).astype(int), np.ceil(np.ptp(outline, axis=0)).astype(int)
    track = Track(
        video=film.path,
        method=options.method,
        time_s=time_s + row * readout_s,
        angle_deg=np.rad2deg(swing.angle_rad - swing.angle_rad[0]),
        sigma_deg=np.rad2deg(np.sqrt(swing.sigma_rad**2 + (swing.shared_rad**2).sum(1))),
        flags=flags,
        pivot_px=(float(x), float(y)),
        template_px=(int(low[0]), int(low[1]), int(size[0]), int(size[1])),
        outline_px=outline,
        plane=view.plane,
        notes=(view.note, f"marker {number} of {options.marker_family}", *film.lost(stamps)),
        lost=film.lost(stamps),
        shared_deg=np.rad2deg(swing.shared_rad),
        tilt=view.tilt,
    )
    return with_repeats(track)


def _detected(
    film: Film, detector: Any, number: int, progress: FrameProgress | None
) -> tuple[list[float], Array]:
    """Presentation times [s] (frames,) and the marker's corners [px] (frames, 4, 2), NaN where it
    is not detected."""
    stamps, corners = [], []
    for frame in frames(film.path, woven=film.woven):
        stamps.append(frame.time_s)
        corners.append(_seen(detector, frame.image).get(number, np.full((4, 2), np.nan)))
        if progress is not None:
            progress(frame.index + 1, film.header.count)
    return stamps, np.array(corners)


@dataclass(frozen=True)
class _Swing:
    """The marker's motion about ``pivot`` (2,) in the plane; (frames,) where not said otherwise.

    Frames without it keep the last angle. ``centre_px`` (frames, 2) is in the picture,
    ``shared_rad`` (frames, errors) what one sigma of pivot and plane does to the angles,
    ``outline`` (4, 2) the marker in the plane at the first frame's angle.
    """

    found: NDArray[np.bool_]
    centre_px: Array
    pivot: Array
    angle_rad: Array
    sigma_rad: Array
    shared_rad: Array
    outline: Array


def _swing(view: CameraView, corners: Array, pivot_px: tuple[float, float] | None) -> _Swing:
    """From corners (frames, 4, 2) [px]; the pivot is ``pivot_px`` where given."""
    found: NDArray[np.bool_] = np.asarray(np.isfinite(corners).all((1, 2)))
    centre_px = _centres(corners)
    flat = view.plane.of_picture(corners.reshape(-1, 2)).reshape(-1, 4, 2)
    centre = view.plane.of_picture(centre_px)
    if pivot_px is None:
        pivot, covariance = _pivot(flat[found], centre[found])
    else:
        pivot, covariance = view.plane.of_picture(np.array([pivot_px]))[0], np.zeros((2, 2))
    arm = centre - pivot
    radius = np.hypot(*arm.T)
    angle = np.full(len(corners), np.nan)
    angle[found] = np.unwrap(np.arctan2(-arm[found, 1], arm[found, 0]))
    usual = float(np.median(radius[found]))
    scatter = _MAD * float(np.median(np.abs(radius[found] - usual)))
    spread = max(float(np.ptp(angle[found])) / np.sqrt(12.0), np.deg2rad(1.0))
    sigma = np.where(found, max(scatter, 1e-3) / usual, spread)
    first = int(np.argmax(found))
    last = np.maximum.accumulate(np.where(found, np.arange(len(found)), first))
    angle, arm, radius = angle[last], arm[last], radius[last]
    # A wrong pivot changes the angle by its error across the arm, less that in the first frame.
    across = np.column_stack([-arm[:, 1], arm[:, 0]]) / radius[:, None] ** 2
    of_pivot = (across - across[0]) @ one_sigma(covariance)
    shared = principal(np.hstack([of_pivot, view.shared_rad(angle - angle[0])]))
    turn = float(angle[0] - angle[last[0]])
    outline = turned(flat[first], (float(pivot[0]), float(pivot[1])), turn)
    return _Swing(found, centre_px, pivot, angle, sigma, shared, outline)


def _detector(dictionary: int) -> cv2.aruco.ArucoDetector:
    how = cv2.aruco.DetectorParameters()
    how.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    return cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(dictionary), how)


def _seen(detector: Any, image: NDArray[np.uint8]) -> dict[int, Array]:
    """Corners (4, 2) [px] of the markers in a picture, by number."""
    corners, numbers, _ = detector.detectMarkers(image)
    if numbers is None:
        return {}
    return {
        int(n): np.asarray(c, np.float64).reshape(4, 2)
        for n, c in zip(np.ravel(numbers), corners, strict=True)
    }


def _chosen(film: Film, options: TrackOptions) -> tuple[Any, int]:
    """A detector of the dictionary that fits, and the number of the marker to follow."""
    images, family, number = film.images, options.marker_family, options.marker_id
    best: tuple[float, Any, int] | None = None
    shown: Counter[int] = Counter()
    for dictionary in _FAMILIES[family]:
        detector = _detector(dictionary)
        seen = [_seen(detector, image) for image in images]
        count = Counter(n for one in seen for n in one)
        shown += count
        for one, times in count.items():
            if times < _LEAST_SHARE * len(images) or number not in (None, one):
                continue
            way = np.ptp([s[one].mean(0) for s in seen if one in s], axis=0)
            if best is None or float(np.hypot(*way)) > best[0]:
                best = float(np.hypot(*way)), detector, one
    if best is None or best[0] < _MOVED_PX:
        others = ", ".join(map(str, sorted(shown))) or "none"
        which = f"marker {number}" if number is not None else "a marker that moves"
        raise InputError(
            f"{film.path}: {which} of the family {family} is not found (seen: {others}); expected "
            "one on the surface with a white rim, at least 20 px wide, check --marker and --id."
        )
    return best[1], best[2]


def _centres(corners: Array) -> Array:
    """The intersection of a square's diagonals, (n, 2): its centre under any perspective."""
    a, b, c, d = corners.transpose(1, 0, 2)
    along, across, between = c - a, d - b, b - a
    cross = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]
    share = (between[:, 0] * across[:, 1] - between[:, 1] * across[:, 0]) / cross
    return np.asarray(a + share[:, None] * along)


def _pivot(corners: Array, centres: Array) -> tuple[Array, Array]:
    """The point about which a marker turns, and its covariance [px^2], over all frames.

    Centres keep their distance from it, and turn about it as the marker's edges turn. Starts
    from ``centre = pivot + turn(edges) arm``, which is linear in pivot and arm.
    """
    edge = corners[:, 1] + corners[:, 2] - corners[:, 0] - corners[:, 3]
    angle = np.unwrap(np.arctan2(-edge[:, 1], edge[:, 0]))
    rows = np.vstack([np.hstack([np.eye(2), turning(float(a - angle[0]))]) for a in angle])
    start = np.linalg.lstsq(rows, centres.ravel(), rcond=None)[0]

    def residuals(free: Array) -> Array:
        arm = centres - free[:2]
        turned_by = np.unwrap(np.arctan2(-arm[:, 1], arm[:, 0])) - angle
        return np.concatenate(
            [(np.hypot(*arm.T) - free[2]) / _CENTRE_PX, (turned_by - free[3]) / _EDGE_RAD]
        )

    arm = centres[0] - start[:2]
    off = float(np.arctan2(-arm[1], arm[0]) - angle[0])
    found = least_squares(residuals, np.array([*start[:2], np.hypot(*arm), off]))
    spread = float(found.fun @ found.fun) / max(found.fun.size - 4, 1)
    covariance = np.linalg.pinv(found.jac.T @ found.jac)[:2, :2] * max(spread, 1.0)
    return found.x[:2], covariance
