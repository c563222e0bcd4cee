"""Angle of a square marker stuck on the surface: ArUco or AprilTag, found by OpenCV.

The marker's centre about the hinge tells the angle far better than its own edges do. The hinge is
the user's, or the point from which all centres keep their distance.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from servosight.models.core import Array, InputError
from servosight.tracking.calibration import Camera, view_of
from servosight.tracking.core import Flag, Track, one_sigma, principal, turned, turning
from servosight.tracking.uncertainty import gaps
from servosight.tracking.video import calm_frames, check, even_times, frames, read_frame_table

Family = Literal["aruco", "apriltag"]

_FAMILIES: dict[Family, tuple[int, ...]] = {
    "aruco": (cv2.aruco.DICT_4X4_1000, cv2.aruco.DICT_5X5_1000, cv2.aruco.DICT_6X6_1000,
              cv2.aruco.DICT_7X7_1000, cv2.aruco.DICT_ARUCO_ORIGINAL),
    "apriltag": (cv2.aruco.DICT_APRILTAG_36h11, cv2.aruco.DICT_APRILTAG_25h9,
                 cv2.aruco.DICT_APRILTAG_16h5),
}  # fmt: skip
_LEAST_SHARE = 0.3  # of the sampled frames that show it
_MOVED_PX = 2.0
# How a centre and an edge are weighed for the hinge: edges lean, all alike, by a tenth of this.
_CENTRE_PX, _EDGE_RAD = 0.03, np.deg2rad(1.0)


def track_marker(
    video: Path,
    family: Family,
    number: int | None = None,
    *,
    pivot: tuple[float, float] | None = None,
    camera: Camera | None = None,
    frame_table: Path | None = None,
    exposure_s: float | None = None,
    readout_s: float | None = None,
    progress: Callable[[int], None] | None = None,
) -> Track:
    """The angle of a marker's centre about the hinge in every frame.

    ``number`` is the marker's own, else the one that moves farthest; ``pivot`` (x, y) [px] the
    hinge, else found from the motion. Times and ``camera`` as in ``track.track``; under a rolling
    shutter an angle belongs to the marker's own row, and so does its time. Sigma is the scatter of
    the centre's distance from the hinge over that distance. Raises ``InputError``.
    """
    header = check(video)
    rolls_s = readout_s or 0.0
    images = [frame.image for frame in calm_frames(video)]
    view = view_of(images, camera)
    finder, chosen = _chosen(video, images, family, number)
    stamps, corners = [], []
    for frame in frames(video):
        stamps.append(frame.time_s)
        corners.append(_seen(finder, frame.image).get(chosen, np.full((4, 2), np.nan)))
        if progress is not None:
            progress(frame.index + 1)
    seen = np.array(corners)
    found = np.isfinite(seen).all((1, 2))
    place = _centres(seen)
    late = np.where(found, place[:, 1] / (images[0].shape[0] - 1) - 0.5, 0.0)
    if frame_table is not None:
        time_s = read_frame_table(frame_table)[0]
    else:
        time_s = even_times(np.array(stamps), header.tick_s) + 0.5 * ((exposure_s or 0.0) + rolls_s)
    flat = view.plane.of_picture(seen.reshape(-1, 2)).reshape(-1, 4, 2)
    centre = view.plane.of_picture(place)
    hinge, doubt = (
        _hinge(flat[found], centre[found])
        if pivot is None
        else (view.plane.of_picture(np.array([pivot]))[0], np.zeros((2, 2)))
    )
    arm = centre - hinge
    radius = np.hypot(*arm.T)
    angle = np.full(len(seen), np.nan)
    angle[found] = np.unwrap(np.arctan2(-arm[found, 1], arm[found, 0]))
    usual = float(np.median(radius[found]))
    scatter = 1.4826 * float(np.median(np.abs(radius[found] - usual)))
    held = np.maximum.accumulate(np.where(found, np.arange(len(found)), np.argmax(found)))
    spread = max(float(np.ptp(angle[found])) / np.sqrt(12.0), np.deg2rad(1.0))
    sigma = np.where(found, max(scatter, 1e-3) / usual, spread)
    angle, arm, radius = angle[held], arm[held], radius[held]
    # A hinge that is off turns the angle by what it moves across the arm, less at the first frame.
    across = np.column_stack([-arm[:, 1], arm[:, 0]]) / radius[:, None] ** 2
    of_hinge = (across - across[0]) @ one_sigma(doubt)
    shared = principal(np.hstack([of_hinge, view.shared_rad(angle - angle[0])]))
    flags = np.where(found, Flag.NONE, Flag.LOST).astype(np.uint8)
    flags |= np.where(gaps(time_s), Flag.AFTER_GAP, Flag.NONE).astype(np.uint8)
    first = flat[int(np.argmax(found))]
    x, y = view.plane.to_picture(hinge[None])[0]
    home = turned(first, (float(hinge[0]), float(hinge[1])), float(angle[0] - angle[held[0]]))
    outline = view.plane.to_picture(home)
    low, size = outline.min(0).astype(int), np.ceil(np.ptp(outline, axis=0)).astype(int)
    return Track(
        video,
        "marker",
        time_s + late * rolls_s,
        np.rad2deg(angle - angle[0]),
        np.rad2deg(np.sqrt(sigma**2 + (shared**2).sum(1))),
        flags,
        (float(x), float(y)),
        (int(low[0]), int(low[1]), int(size[0]), int(size[1])),
        outline,
        view.plane,
        (view.note, f"marker {chosen} of {family}"),
        np.rad2deg(shared),
    )


def _finder(dictionary: int) -> cv2.aruco.ArucoDetector:
    how = cv2.aruco.DetectorParameters()
    how.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    return cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(dictionary), how)


def _seen(finder: Any, image: NDArray[np.uint8]) -> dict[int, Array]:
    """Corners (4, 2) [px] of the markers in a picture, by number."""
    corners, numbers, _ = finder.detectMarkers(image)
    if numbers is None:
        return {}
    return {
        int(n): np.asarray(c, np.float64).reshape(4, 2)
        for n, c in zip(np.ravel(numbers), corners, strict=True)
    }


def _chosen(
    video: Path, images: list[NDArray[np.uint8]], family: Family, number: int | None
) -> tuple[Any, int]:
    """The dictionary that fits, and the marker to follow in it."""
    best: tuple[float, Any, int] | None = None
    shown: Counter[int] = Counter()
    for dictionary in _FAMILIES[family]:
        finder = _finder(dictionary)
        seen = [_seen(finder, image) for image in images]
        count = Counter(n for one in seen for n in one)
        shown += count
        for one, times in count.items():
            if times < _LEAST_SHARE * len(images) or number not in (None, one):
                continue
            way = np.ptp([s[one].mean(0) for s in seen if one in s], axis=0)
            if best is None or float(np.hypot(*way)) > best[0]:
                best = float(np.hypot(*way)), finder, one
    if best is None or best[0] < _MOVED_PX:
        others = ", ".join(map(str, sorted(shown))) or "none"
        which = f"marker {number}" if number is not None else "a marker that moves"
        raise InputError(
            f"{video}: {which} of the family {family} is not found (seen: {others}); expected one "
            "on the surface with a white rim, at least 20 px wide, check --marker and --id."
        )
    return best[1], best[2]


def _centres(corners: Array) -> Array:
    """Where a square's diagonals meet, (n, 2): its centre however it is seen."""
    a, b, c, d = corners.transpose(1, 0, 2)
    along, across, between = c - a, d - b, b - a
    cross = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]
    share = (between[:, 0] * across[:, 1] - between[:, 1] * across[:, 0]) / cross
    return np.asarray(a + share[:, None] * along)


def _hinge(corners: Array, centres: Array) -> tuple[Array, Array]:
    """The point about which a marker turns, and its covariance [px^2], over all frames.

    Centres keep their distance from it, and turn about it as the marker's edges turn. Starts
    from ``centre = hinge + turn(edges) arm``, which is linear in hinge and arm.
    """
    edge = corners[:, 1] + corners[:, 2] - corners[:, 0] - corners[:, 3]
    angle = np.unwrap(np.arctan2(-edge[:, 1], edge[:, 0]))
    rows = np.vstack([np.hstack([np.eye(2), turning(float(a - angle[0]))]) for a in angle])
    start = np.linalg.lstsq(rows, centres.ravel(), rcond=None)[0]

    def unlike(free: Array) -> Array:
        arm = centres - free[:2]
        turned_by = np.unwrap(np.arctan2(-arm[:, 1], arm[:, 0])) - angle
        return np.concatenate(
            [(np.hypot(*arm.T) - free[2]) / _CENTRE_PX, (turned_by - free[3]) / _EDGE_RAD]
        )

    arm = centres[0] - start[:2]
    off = float(np.arctan2(-arm[1], arm[0]) - angle[0])
    found = least_squares(unlike, np.array([*start[:2], np.hypot(*arm), off]))
    spread = float(found.fun @ found.fun) / max(found.fun.size - 4, 1)
    covariance = np.linalg.pinv(found.jac.T @ found.jac)[:2, :2] * max(spread, 1.0)
    return found.x[:2], covariance
