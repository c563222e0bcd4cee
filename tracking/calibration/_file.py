"""Reading and writing camera.toml, the result of a calibration."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from msgspec import Meta

from servosight.models.core import (
    InputError,
    Kind,
    marked_toml,
    read_settings,
    validated,
    write_text,
)
from servosight.tracking.core import CameraGeometry, Lens

if TYPE_CHECKING:
    from servosight.tracking.calibration._board import Calibration

FORMAT = 1
LARGEST = 1e9
"""Larger than any length, matrix entry or coefficient of a camera."""


def write_camera(path: Path, calibration: Calibration) -> None:
    """Write camera.toml, completely or not at all."""
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


def read_camera(path: Path) -> CameraGeometry:
    """Read camera.toml."""
    table = read_settings(path, "a file that `servosight calibrate` wrote")
    return camera_of(table, str(path))


_Number = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
_Pixels = Annotated[float, Meta(gt=0.0, le=LARGEST)]
_Pair = tuple[_Number, _Number]
_Triple = tuple[_Number, _Number, _Number]


def _meta(what: str) -> Meta:
    fix = "write what `servosight calibrate` wrote"
    return Meta(description=f"{what}, each at most {LARGEST:g}", extra={"fix": fix})


@dataclass(frozen=True)
class _Lens:
    focal_px: Annotated[tuple[_Pixels, _Pixels], _meta("2 numbers above 0")]
    principal_px: Annotated[_Pair, _meta("2 numbers")]
    distortion: Annotated[tuple[_Number, _Number, _Number, _Number, _Number], _meta("5 numbers")]


@dataclass(frozen=True)
class _Plane:
    onto: Annotated[tuple[_Triple, _Triple, _Triple], _meta("3 x 3 numbers")]


_Size = Annotated[
    int,
    Meta(
        ge=1,
        le=int(LARGEST),
        description="a whole number of pixels above 0",
        extra={"fix": "write what `servosight calibrate` wrote"},
    ),
]


@dataclass(frozen=True)
class _CalibrationKeys:
    lens: _Lens | None = None
    plane: _Plane | None = None
    width: _Size | None = None
    height: _Size | None = None


def camera_of(table: object, source: str) -> CameraGeometry:
    """The camera of a table with ``lens`` and ``plane``, as in camera.toml or recording.toml."""
    keys = validated(table, _CalibrationKeys, source, notes=True)
    if keys.lens is None and keys.plane is None:
        raise InputError(
            f"{source}: has neither a table lens nor a table plane; expected what `servosight "
            "calibrate` writes."
        )
    lens = onto = None
    if keys.lens is not None:
        lens = Lens(keys.lens.focal_px, keys.lens.principal_px, keys.lens.distortion)
    if keys.plane is not None:
        onto = np.array(keys.plane.onto)
        if abs(float(np.linalg.det(onto))) < 1e-15:
            raise InputError(
                f"{source}: key plane.onto maps the picture to a line; expected the matrix that "
                "`servosight calibrate` wrote."
            )
    if keys.width is None or keys.height is None:
        return CameraGeometry(lens, onto)
    return CameraGeometry(lens, onto, (keys.width, keys.height))
