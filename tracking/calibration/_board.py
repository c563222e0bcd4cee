"""Lens and plane from pictures of a board: Zhang's method (2000), by OpenCV."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np
from PIL import Image as Picture
from PIL import ImageOps

from servosight.models.core import Array, Image, InputError
from servosight.tracking.core import CameraGeometry, Lens
from servosight.tracking.video import sample_frames

BoardKind = Literal["checkerboard", "aruco"]

PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm")
_FROM_VIDEO = 40
_LEAST_VIEWS = 4
_LEAST_CORNERS = 8
_MARKER_SHARE = 0.75
_SURE = 5.0
_PX_PER_SQUARE = 100


@dataclass(frozen=True)
class Board:
    """``columns`` by ``rows`` squares of ``square_mm``.

    "aruco" is a ChArUco board: a 4x4 marker of three quarters of its size in every light square.
    """

    kind: BoardKind
    columns: int
    rows: int
    square_mm: float

    @property
    def charuco(self) -> cv2.aruco.CharucoBoard:
        """OpenCV's own description of it."""
        marks = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_1000)
        marker = _MARKER_SHARE * self.square_mm
        return cv2.aruco.CharucoBoard((self.columns, self.rows), self.square_mm, marker, marks)

    def corners(self, image: Image) -> tuple[Array, Array] | None:
        """Inner corners seen in a picture: x, y [px] and on the board [mm], each (corners, 2)."""
        if self.kind == "aruco":
            detector: Any = cv2.aruco.CharucoDetector(self.charuco)  # ids may be None, unhinted
            found, ids, _, _ = detector.detectBoard(image)
            if ids is None or len(ids) < _LEAST_CORNERS:
                return None
            place = np.asarray(self.charuco.getChessboardCorners())[np.ravel(ids), :2]
            return np.asarray(found, np.float64).reshape(-1, 2), place.astype(np.float64)
        size = (self.columns - 1, self.rows - 1)
        how = cv2.CALIB_CB_ACCURACY + cv2.CALIB_CB_NORMALIZE_IMAGE + cv2.CALIB_CB_EXHAUSTIVE
        seen, points = cv2.findChessboardCornersSB(image, size, flags=how)
        if not seen:
            return None
        x, y = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
        place = self.square_mm * np.column_stack([x.ravel(), y.ravel()]).astype(np.float64)
        return np.asarray(points, np.float64).reshape(-1, 2), place

    def picture(self) -> Image:
        """The board to print, 100 px a square with a white rim."""
        size = (self.columns * _PX_PER_SQUARE, self.rows * _PX_PER_SQUARE)
        if self.kind == "aruco":
            board = np.asarray(self.charuco.generateImage(size), np.uint8)
        else:
            y, x = np.indices(size[::-1]) // _PX_PER_SQUARE
            board = np.where((x + y) % 2, 255, 0).astype(np.uint8)
        return np.pad(board, _PX_PER_SQUARE, constant_values=255)


@dataclass(frozen=True)
class Calibration:
    """The calibration from pictures of a board; ``errors_px`` is each picture's rms, by name."""

    camera: CameraGeometry
    size_px: tuple[int, int]
    errors_px: dict[str, float]
    rms_px: float
    quality: str


def read_views(sources: Sequence[Path]) -> dict[str, Image]:
    """Grey pictures by name: image files, and some 40 frames of each video."""
    views: dict[str, Image] = {}
    for source in sources:
        if source.suffix.lower() in PICTURES:
            views[str(source)] = _read(source)
            continue
        for frame in sample_frames(source, _FROM_VIDEO):
            views[f"{source}@{frame.time_s:.3f}s"] = frame.image
    sizes = {image.shape for image in views.values()}
    if len(sizes) > 1:
        raise InputError(
            f"{sources[0]}: pictures of {len(sizes)} sizes are mixed; expected all of one camera "
            "at one resolution, name those alone."
        )
    return views


def _read(file: Path) -> Image:
    """A grey picture, rotated upright according to its EXIF data.

    By Pillow, whose readers raise errors where OpenCV's print warnings of their own.
    """
    try:
        with warnings.catch_warnings(), Picture.open(file) as picture:
            warnings.simplefilter("ignore")
            picture.draft("L", picture.size)  # of a JPEG, the luminance that it holds
            upright = ImageOps.exif_transpose(picture)
            if upright.mode.startswith("I"):  # 16 bits, which Pillow clips to 8
                return np.asarray(np.asarray(upright) >> 8, np.uint8)
            return np.asarray(upright.convert("L"), np.uint8)
    except Exception as error:  # a damaged file's errors are of a dozen kinds
        raise InputError(
            f"{file}: cannot be read as a picture; expected a PNG, JPEG, BMP or TIFF file, check "
            "the name."
        ) from error


def write_picture(file: Path, image: Image) -> None:
    """Write a grey picture as PNG, completely or not at all."""
    from servosight.models.core import marked_png, write_bytes

    write_bytes(file, marked_png(bytes(cv2.imencode(".png", image)[1])))


def calibrate(views: dict[str, Image], board: Board, plane: Path | None = None) -> Calibration:
    """Lens from at least four views of the board, plane from the picture where it lies in it.

    With fewer views only the ``plane`` is found, for a lens without distortion. Raises
    ``InputError`` where the board is not found often enough.
    """
    first = next(iter(views.values()))
    size = (first.shape[1], first.shape[0])
    found = {name: seen for name, image in views.items() if (seen := board.corners(image))}
    if len(found) < _LEAST_VIEWS and plane is None:
        raise InputError(
            f"{next(iter(views))}: the {board.kind} of {board.columns} x {board.rows} squares is "
            f"found in {len(found)} of {len(views)} pictures; expected it in at least "
            f"{_LEAST_VIEWS}, whole and tilted differently, check --columns and --rows (squares, "
            "not corners)."
        )
    lens, rms, quality = None, 0.0, "lens not calibrated"
    errors: dict[str, float] = {}
    if len(found) >= _LEAST_VIEWS:
        lens, errors, rms, quality = _lens(found, size)
    onto = None
    if plane is not None:
        seen = board.corners(_read(plane))
        if seen is None:
            raise InputError(
                f"{plane}: the {board.kind} of {board.columns} x {board.rows} squares is not found "
                "in it; expected it whole, lying in the surface's plane, take that picture again."
            )
        straight = lens.straight(seen[0]) if lens is not None else seen[0]
        matrix, _ = cv2.findHomography(straight, seen[1], 0)
        onto = np.asarray(matrix, np.float64)
    return Calibration(CameraGeometry(lens, onto, size), size, errors, rms, quality)


def _lens(
    found: dict[str, tuple[Array, Array]], size: tuple[int, int]
) -> tuple[Lens, dict[str, float], float, str]:
    board = [
        np.column_stack([place, np.zeros(len(place))]).astype(np.float32)
        for _, place in found.values()
    ]
    seen = [points.astype(np.float32).reshape(-1, 1, 2) for points, _ in found.values()]
    # A coefficient that the views do not determine would distort the corners that no board
    # covered: leave it out.
    for fixed in (0, cv2.CALIB_FIX_K3, cv2.CALIB_FIX_K3 + cv2.CALIB_FIX_K2):
        rms, matrix, bent, turns, _, doubt, _, errors = cv2.calibrateCameraExtended(
            board, seen, size, np.zeros((3, 3)), np.zeros(5), flags=fixed
        )
        k, sigma = np.ravel(bent)[:5], np.ravel(doubt)[4:9]
        last = 1 if fixed & cv2.CALIB_FIX_K3 else 4
        if abs(k[last]) > _SURE * sigma[last]:
            break
    lens = Lens(
        (float(matrix[0, 0]), float(matrix[1, 1])),
        (float(matrix[0, 2]), float(matrix[1, 2])),
        (float(k[0]), float(k[1]), float(k[2]), float(k[3]), float(k[4])),
    )
    hull = cv2.convexHull(np.vstack(seen))
    share = float(cv2.contourArea(hull)) / (size[0] * size[1])
    tilts = [float(np.arccos(min(abs(cv2.Rodrigues(turn)[0][2, 2]), 1.0))) for turn in turns]
    quality = _quality(float(rms), share, float(np.rad2deg(max(tilts))), lens, np.ravel(doubt))
    per_view = dict(zip(found, np.ravel(errors).tolist(), strict=True))
    return lens, per_view, float(rms), quality


def _quality(rms: float, share: float, tilt_deg: float, lens: Lens, doubt: Array) -> str:
    """A sentence on the accuracy of the lens."""
    advice = []
    if rms > 0.5:
        advice.append("corner errors exceed half a pixel: use a flatter board, sharper pictures")
    if share < 0.6:
        advice.append(f"the board covered {100 * share:.0f} % of the picture: show it at the edges")
    if tilt_deg < 20.0:
        advice.append(f"it was tilted by {tilt_deg:.0f} deg at most: tilt it by 30 to 45 deg")
    focal = float(doubt[0]) / lens.focal_px[0]
    result = f"corners fit to {rms:.3f} px rms, focal length to {100 * focal:.2g} %"
    return f"{result}; {'; '.join(advice)}" if advice else f"{result}, picture covered: good"
