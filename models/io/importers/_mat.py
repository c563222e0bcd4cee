"""MATLAB files: the EMPS benchmark as it stands, others by --map.

EMPS (electro-mechanical positioning system): Janot, Gautier, Brunot, "Data set and reference
models of EMPS", 2019. ``t`` [s], ``qg`` reference [m], ``qm`` measured position [m].
"""

from __future__ import annotations

import io
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models.core import Array, InputError, plain_name, read_bytes
from servosight.models.io.importers import mat_reader
from servosight.models.io.importers._request import (
    Column,
    Imported,
    Raw,
    Request,
    assemble,
    unit_of,
)

EMPS = {"time": Column("t", "s"), "command": Column("qg", "m"), "angle": Column("qm", "m")}
EMPS_SCALE = 100.0
"""Degrees that show one metre: a centimetre of the axis reads as a degree."""
LARGEST_MAT = 1 << 28
LONGEST_READ_S = 60.0


def read_mat(path: Path, request: Request) -> Imported:
    """Read vectors of a MATLAB file (up to version 7.2)."""
    variables = _variables(path)
    columns = {**EMPS, **request.columns}
    if request.unit_scale is None and any(columns[name].unit == "m" for name in columns):
        request = replace(request, unit_scale=EMPS_SCALE)
    raw: dict[str, Raw] = {}
    for quantity, column in columns.items():
        values = _vector(path, variables, quantity, column.name)
        unit = unit_of(quantity, column, request)
        raw[quantity] = Raw(column.name, unit, values, range(1, values.size + 1), "sample")
        if values.size != raw["time"].values.size:
            raise InputError(
                f"{path}: variable {column.name} has {values.size} samples and "
                f"{raw['time'].column} has {raw['time'].values.size}, expected the same number; "
                f"map another one"
            )
    scalars = {
        name: float(value.ravel()[0])
        for name, value in variables.items()
        if _is_numeric(value) and value.size == 1 and np.isfinite(value.ravel()[0])
    }
    source = {"name": plain_name(path.name), "format": "mat", **scalars}
    return Imported(assemble(path, raw, request, {"source": source}))


def _variables(path: Path) -> dict[str, Any]:
    """Numeric arrays by name, as :mod:`servosight.models.io.importers.mat_reader` finds them."""
    content = read_bytes(path, "a MATLAB file", LARGEST_MAT)
    try:
        reader = subprocess.run(
            [sys.executable, "-P", "-m", mat_reader.__name__],
            input=content,
            capture_output=True,
            timeout=LONGEST_READ_S,
        )
    except subprocess.TimeoutExpired:
        why = f"it takes more than {LONGEST_READ_S:g} s"
    else:
        if reader.returncode == 0:
            with np.load(io.BytesIO(reader.stdout), allow_pickle=False) as arrays:
                return {name.removeprefix(mat_reader.PREFIX): arrays[name] for name in arrays}
        lines = reader.stderr.decode("utf-8", "replace").strip().splitlines()
        why = lines[-1][:120] if lines and reader.returncode > 0 else "its header is damaged"
    raise InputError(
        f"{path}: cannot be read as a MATLAB file ({why}); expected a complete file of version "
        "7.2 or "
        f"older, so save it with -v7"
    )


def _vector(path: Path, variables: dict[str, Any], quantity: str, name: str) -> Array:
    value = variables.get(name)
    if value is None or not _is_numeric(value) or max(value.shape, default=0) != value.size:
        vectors = [key for key, one in variables.items() if _is_numeric(one) and one.size > 1]
        raise InputError(
            f"{path}: no vector {name} for the {quantity}, expected one of "
            f"{', '.join(vectors) or '(none)'}; give --map {quantity}=VARIABLE:UNIT"
        )
    return np.asarray(value, dtype=np.float64).ravel()


def _is_numeric(value: Any) -> bool:
    return isinstance(value, np.ndarray) and value.dtype.kind in "iuf"
