"""camera.toml: what a calibration told, in and out."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from servosight.models.core import Array, InputError, Kind, marked_toml, read_settings, write_text
from servosight.tracking.core import CameraGeometry, Lens

if TYPE_CHECKING:
    from servosight.tracking.calibration._board import Calibration

FORMAT = 1
LARGEST = 1e9
"""No length, entry of a matrix or coefficient of a camera comes near this."""


def write_camera(path: Path, calibration: Calibration) -> None:
    """Write camera.toml, whole or not at all."""
    import tomli_w

    table: dict[str, Any] = {
        "format": FORMAT,
        "width": calibration.size_px[0],
        "height": calibration.size_px[1],
        "rms_px": calibration.rms_px,
        "quality": calibration.quality,
    }
    lens, onto = calibration.camera.lens, calibration.camera.onto
    if lens is not None:
        table["lens"] = {
            "focal_px": list(lens.focal_px),
            "principal_px": list(lens.principal_px),
            "distortion": list(lens.distortion),
        }
    if onto is not None:
        table["plane"] = {"onto": [[float(v) for v in row] for row in onto]}
    table["view"] = [{"name": n, "rms_px": e} for n, e in calibration.errors_px.items()]
    write_text(path, marked_toml(Kind.CAMERA, tomli_w.dumps(table)))


def read_camera(path: Path, size_px: tuple[int, int] | None = None) -> CameraGeometry:
    """Read camera.toml; ``size_px`` (width, height) is that of the video it is meant for."""
    table = read_settings(path, "a file that `servosight calibrate` wrote")
    known = (table.get("width"), table.get("height"))
    if size_px is not None and None not in known and known != size_px:
        raise InputError(
            f"{path}: keys width and height say {known[0]} x {known[1]} px and the video has "
            f"{size_px[0]} x {size_px[1]}; expected a calibration at the video's own size, "
            "calibrate again."
        )
    return camera_of(table, str(path))


def camera_of(table: object, source: str) -> CameraGeometry:
    """The camera of a table with ``lens`` and ``plane``, as in camera.toml or recording.toml."""
    if not isinstance(table, Mapping):
        raise InputError(
            f"{source}: is {table!r} and no table; expected the tables lens and plane that "
            "`servosight calibrate` writes."
        )
    lens, onto = None, None
    if "lens" in table:
        focal = _numbers(table, source, "lens", "focal_px", (2,))
        centre = _numbers(table, source, "lens", "principal_px", (2,))
        k1, k2, p1, p2, k3 = _numbers(table, source, "lens", "distortion", (5,))
        if min(focal) <= 0.0:
            raise InputError(f"{source}: key lens.focal_px is not above 0; expected pixels.")
        lens = Lens((focal[0], focal[1]), (centre[0], centre[1]), (k1, k2, p1, p2, k3))
    if "plane" in table:
        onto = _numbers(table, source, "plane", "onto", (3, 3))
        if abs(float(np.linalg.det(onto))) < 1e-15:
            raise InputError(
                f"{source}: key plane.onto maps the picture to a line; expected the matrix that "
                "`servosight calibrate` wrote."
            )
    if lens is None and onto is None:
        raise InputError(
            f"{source}: has neither a table lens nor a table plane; expected what `servosight "
            "calibrate` writes."
        )
    return CameraGeometry(lens, onto)


def _numbers(
    table: Mapping[str, Any], source: str, part: str, key: str, shape: tuple[int, ...]
) -> Array:
    try:
        values = np.array(table[part][key], np.float64)
    except (KeyError, TypeError, ValueError, OverflowError):
        values = np.empty(0)
    if values.shape != shape or not np.isfinite(values).all():
        raise InputError(
            f"{source}: key {part}.{key} is not {' x '.join(map(str, shape))} numbers; expected "
            "those that `servosight calibrate` writes."
        )
    if np.abs(values).max() > LARGEST:
        raise InputError(
            f"{source}: key {part}.{key} holds {values.flat[np.abs(values).argmax()]:g}; expected "
            f"numbers up to {LARGEST:g}, as `servosight calibrate` writes them."
        )
    return values
