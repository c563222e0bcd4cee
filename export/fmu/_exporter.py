"""``--to fmu`` and ``--to fmu2``: the model's C in an FMU, loaded and run before it is kept."""

from __future__ import annotations

import hashlib
import shutil
import tempfile
import uuid
import zipfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from servosight.export.core import (
    Exporter,
    ExportRequest,
    ExportTrial,
    Omission,
    Response,
    filled,
    mark_of,
    number,
)
from servosight.export.csource import (
    HeldSteps,
    check_equal,
    compile_c,
    held_steps,
    missing,
    model_source,
)
from servosight.export.fmu._description import TIME_REFERENCE, build_description, description
from servosight.export.fmu._extras import extras
from servosight.export.fmu._variables import has_exchange, nominals
from servosight.models.core import InputError, either
from servosight.models.fmu import open_fmu

OWN = "extra/org.servosight"
"""Folder of the archive for what importers pass over."""
EXCHANGE_DEG = 1e-4
"""Largest difference of the linear core by a solver with a tolerance of 1e-8."""
EXCHANGE_S = 4.0
"""So much of a trial is run by model exchange, whose solver begins anew at each row."""
_DATE = (1980, 1, 1, 0, 0, 0)
_HEADERS = {
    2: ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    3: ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}


def _write(version: int, request: ExportRequest, path: Path) -> None:
    why = missing()
    if why is not None:
        raise InputError(f"{either('to=fmu', '--to fmu')}: {why}, then export again")
    files = _sources(version, request)
    token = _token(files)
    files = {name: text.replace("@token@", token) for name, text in files.items()}
    content = {f"sources/{name}": text.encode() for name, text in files.items()}
    if version == 3:
        content["sources/buildDescription.xml"] = build_description(request).encode()
    content["modelDescription.xml"] = description(request, version, token).encode()
    content[_binary_name(version, request)] = _binary(version, files)
    content |= {f"{OWN}/{name}": text.encode() for name, text in extras(request).items()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.comment = mark_of("fmu").encode()
        for name in sorted(content, key=lambda one: (one != "modelDescription.xml", one)):
            entry = zipfile.ZipInfo(name, _DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (0o100755 if name.startswith("binaries/") else 0o100644) << 16
            archive.writestr(entry, content[name])


def _sources(version: int, request: ExportRequest) -> dict[str, str]:
    """C files and headers by name; the token is still to be put in."""
    import fmpy

    angle, speed = nominals(request)
    words = {
        "name": request.name,
        "NAME": request.name.upper(),
        "time": str(TIME_REFERENCE),
        "exchange": "1" if has_exchange(request) else "0",
        "exchange_words": ", and model exchange" if has_exchange(request) else "",
        "nominal_angle": number(angle),
        "nominal_speed": number(speed),
        "token": "@token@",
    }
    found = {
        "model.c": model_source(request, kind="fmu"),
        "instance.c": filled("fmu", "instance.c", words),
        f"fmi{version}.c": filled("fmu", f"fmi{version}.c", words),
    }
    headers = Path(fmpy.__file__).parent / "c-code"
    return found | {name: (headers / name).read_text("utf-8") for name in _HEADERS[version]}


def _token(files: dict[str, str]) -> str:
    """The same for the same sources, so that the same model gives the same FMU."""
    digest = hashlib.sha256("".join(f"{name}\0{files[name]}\0" for name in sorted(files)).encode())
    return f"{{{uuid.UUID(bytes=digest.digest()[:16])}}}"


def _binary_name(version: int, request: ExportRequest) -> str:
    import fmpy

    folder = fmpy.platform if version == 2 else fmpy.platform_tuple
    return f"binaries/{folder}/{request.name}{fmpy.sharedLibraryExtension}"


def _binary(version: int, files: dict[str, str]) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        for name, text in files.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        source, library = Path(folder) / f"fmi{version}.c", Path(folder) / "library"
        options = ["-shared", "-fPIC", "-fvisibility=hidden"]
        compile_c([*options, "-o", str(library), str(source), "-lm"])
        return library.read_bytes()


def _run(request: ExportRequest, path: Path, trial: ExportTrial) -> Response:
    """Load it and take the trial's steps, by each interface that it has."""
    _check_valid(path)
    steps = held_steps(trial)
    start = {"initial_angle": trial.start_deg, "initial_speed": 0.0}
    words = {"command_name": "command", "output_name": "angle"}
    with open_fmu(path, interface="CoSimulation") as fmu:
        angle = fmu.run(steps.time_s, steps.command_deg, start=start, **words)
    check_equal(request, trial, steps, angle)
    if has_exchange(request):
        first = np.searchsorted(steps.time_s, steps.time_s[0] + EXCHANGE_S)
        part = HeldSteps(steps.time_s[: first + 1], steps.command_deg[:first])
        with open_fmu(path, interface="ModelExchange") as fmu:
            solved = fmu.run(part.time_s, part.command_deg, start=start, **words)
        error = float(np.max(np.abs(solved - angle[: first + 1])))
        if not error <= EXCHANGE_DEG:
            raise RuntimeError(
                f"by model exchange the FMU differs from the model by {error:.3g} deg, at most "
                f"{EXCHANGE_DEG:g} expected; nothing was written"
            )
    return Response(time_s=steps.time_s, angle_deg=angle)


def _check_valid(path: Path) -> None:
    """Raise RuntimeError for what fmpy finds wrong; under an ending by which it knows an FMU."""
    from fmpy.validation import validate_fmu

    with tempfile.TemporaryDirectory() as folder:
        problems = validate_fmu(shutil.copyfile(path, Path(folder) / "model.fmu").as_posix())
    if problems:
        raise RuntimeError(f"the FMU is not valid ({problems[0]}); nothing was written")


def _omissions(request: ExportRequest) -> tuple[Omission, ...]:
    return ()


def _notes(request: ExportRequest) -> tuple[str, ...]:
    if has_exchange(request):
        return ("it has co-simulation and model exchange",)
    return ("it has co-simulation; model exchange is for a model without effects",)


def _exporter(version: int) -> Exporter:
    write: Callable[[ExportRequest, Path], None] = partial(_write, version)
    return Exporter(
        target=f"FMI {version}.0 (run by fmpy)",
        write=write,
        omissions=_omissions,
        run=_run,
        notes=_notes,
    )


FMU2 = _exporter(2)
"""The exporter of ``--to fmu2``."""
FMU3 = _exporter(3)
"""The exporter of ``--to fmu``."""
