"""Other methods to measure the angle, on the same frames: from a picture and the last angle.

All are given the true pivot and start from a clean first frame, which favours them.

"""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

import cv2
import numpy as np

from servosight.models.core import Array, Image

Peer = Callable[[Image, float], float]

_MARKER_PX = 60
_ARUCO = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)


def template(first: Image, pivot_px: tuple[float, float], box: tuple[int, int, int, int]) -> Peer:
    """Plain ``matchTemplate``, unrotated, parabola at the peak."""
    x, y, width, height = box
    part = first[y : y + height, x : x + width]
    arm = np.array([x, y]) + 0.5 * np.array([width - 1, height - 1]) - pivot_px

    def measure(picture: Image, _last_deg: float) -> float:
        score = cv2.matchTemplate(picture, part, cv2.TM_CCOEFF_NORMED)
        _, _, _, (column, row) = cv2.minMaxLoc(score)
        past = np.array([_vertex(score[row], column), _vertex(score.T[column], row)])
        place = np.array([column, row]) + past
        now = place + 0.5 * np.array([width - 1, height - 1]) - pivot_px
        return _turn_deg(arm, now)

    return measure


def ecc(first: Image, pivot_px: tuple[float, float], outline_px: Array) -> Peer:
    """OpenCV's ``findTransformECC``, Euclidean, over the whole surface."""
    mask = np.zeros(first.shape, np.uint8)
    cv2.fillPoly(mask, [np.round(outline_px).astype(np.int32)], 255)
    mask = cv2.erode(mask, np.ones((5, 5), np.uint8))
    rule = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 50, 1e-6)

    def measure(picture: Image, last_deg: float) -> float:
        start = cv2.getRotationMatrix2D(pivot_px, last_deg, 1.0).astype(np.float32)
        try:
            _, warp = cv2.findTransformECC(
                first, picture, start, cv2.MOTION_EUCLIDEAN, rule, mask, 5
            )
        except cv2.error:
            return float("nan")
        return float(np.rad2deg(np.arctan2(warp[0, 1], warp[0, 0])))

    return measure


def with_marker(
    pictures: Sequence[Image], pivot_px: tuple[float, float], angle_deg: Array
) -> list[Image]:
    """The pictures with an ArUco marker of 60 px stuck to the surface, as noisy as the rest."""
    scale, side = 4, pictures[0].shape[::-1]
    rng = np.random.default_rng(1)
    print_ = cv2.aruco.generateImageMarker(_ARUCO, 7, _MARKER_PX * scale)
    sheet = cv2.copyMakeBorder(print_, 32, 32, 32, 32, cv2.BORDER_CONSTANT, value=(255,))
    half = 0.5 * (sheet.shape[0] - 1)
    shown = []
    for picture, angle in zip(pictures, angle_deg, strict=True):
        turn = np.vstack([cv2.getRotationMatrix2D(pivot_px, float(angle), 1.0), [0, 0, 1]])
        place = np.array(
            [[1 / scale, 0, pivot_px[0] + 80 - half / scale],
             [0, 1 / scale, pivot_px[1] - half / scale], [0, 0, 1]]
        )  # fmt: skip
        onto = (turn @ place)[:2]
        soft = cv2.GaussianBlur(sheet, (0, 0), 0.6 * scale).astype(np.float32) * 0.7 + 30.0
        ink = cv2.warpAffine(soft, onto, side, flags=cv2.INTER_LINEAR)
        share = cv2.warpAffine(np.ones_like(soft), onto, side, flags=cv2.INTER_LINEAR)
        ink += 2.0 * rng.standard_normal(ink.shape).astype(np.float32) * share
        shown.append(np.clip(np.round(picture * (1 - share) + ink), 0, 255).astype(np.uint8))
    return shown


def aruco(pivot_px: tuple[float, float]) -> Peer:
    """OpenCV's ArUco with sub-pixel corners: its centre about the known pivot."""
    settings = cv2.aruco.DetectorParameters()
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    detector = cv2.aruco.ArucoDetector(_ARUCO, settings)

    def measure(picture: Image, _last_deg: float) -> float:
        corners, _, _ = detector.detectMarkers(picture)
        if not corners:
            return float("nan")
        return _turn_deg(np.array([1.0, 0.0]), corners[0].reshape(4, 2).mean(0) - pivot_px)

    return measure


def pyidi(
    pictures: Sequence[Image],
    pivot_px: tuple[float, float],
    box: tuple[int, int, int, int],
    folder: Path,
) -> tuple[list[float], float] | str:
    """Angles [deg] by the rigid correlation of ``pyidi`` and processor time [s]; or why not."""
    maker = shutil.which("uv") or str(Path(".venv-uv/bin/uv").resolve())
    home = folder / "pyidi"
    script = Path(__file__).with_name("pyidi_alone.py")
    python = home / "bin" / "python"
    x, y, width, height = box
    centre = np.round([x + 0.5 * (width - 1), y + 0.5 * (height - 1)])
    given, found = folder / "frames.npz", folder / "found.npz"
    np.savez(given, pictures=np.stack(pictures), centre_px=centre, side_px=min(width, height))
    steps: list[list[str]] = [[str(python), str(script), str(given), str(found)]]
    if not python.exists():
        steps = [
            [maker, "venv", "--quiet", str(home)],
            [maker, "pip", "install", "--quiet", "--python", str(python), "pyidi"],
            *steps,
        ]
    for step in steps:
        try:
            done = subprocess.run(step, capture_output=True, text=True, check=False, timeout=900)
        except (OSError, subprocess.TimeoutExpired) as error:
            return type(error).__name__
        if done.returncode:
            return (done.stderr.strip().splitlines() or ["no reason given"])[-1]
    with np.load(found) as loaded:
        arm = centre - pivot_px
        return [_turn_deg(arm, arm + shift) for shift in loaded["shift_px"]], float(
            loaded["seconds"]
        )


def _turn_deg(before: Array, after: Array) -> float:
    """Counter-clockwise turn as seen, y down."""
    cross = before[1] * after[0] - before[0] * after[1]
    return float(np.rad2deg(np.arctan2(cross, before @ after)))


def _vertex(line: Array, at: int) -> float:
    if not 0 < at < len(line) - 1:
        return 0.0
    before, top, after = (float(v) for v in line[at - 1 : at + 2])
    return 0.5 * (before - after) / (before - 2.0 * top + after)
