"""``--to c``: the whole model's step in one C99 file, compiled and run before it is kept."""

from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path

import numpy as np

from servosight.export.core import Exporter, ExportRequest, ExportTrial, Omission, Response, filled
from servosight.export.csource._compile import TIME_S, compile_c, missing
from servosight.export.csource._model import model_source
from servosight.export.csource._reference import check_equal, held_steps
from servosight.models.core import write_text


def _write(request: ExportRequest, path: Path) -> None:
    write_text(path, model_source(request))


def _run(request: ExportRequest, path: Path, trial: ExportTrial) -> Response:
    """Compile the file into a program that takes steps and prints angles."""
    steps = held_steps(trial)
    words = {"name": request.name, "NAME": request.name.upper()}
    rows = np.column_stack([steps.command_deg, np.diff(steps.time_s)])
    given = f"{trial.start_deg!r}\n" + "".join(f"{u!r} {h!r}\n" for u, h in rows.tolist())
    with tempfile.TemporaryDirectory() as folder:
        source, program = Path(folder) / "main.c", Path(folder) / "main"
        text = filled("csource", "trial.c", words)
        source.write_text(path.read_text(encoding="utf-8") + text, encoding="utf-8")
        compile_c(["-o", str(program), str(source), "-lm"])
        done = subprocess.run(
            [str(program)], input=given, capture_output=True, text=True, timeout=TIME_S, check=False
        )
    angle = np.array(done.stdout.split(), dtype=np.float64)
    if done.returncode != 0 or angle.size != steps.time_s.size:
        raise RuntimeError(f"the compiled model ended after {angle.size} steps; nothing was kept")
    check_equal(request, trial, steps, angle)
    return Response(time_s=steps.time_s, angle_deg=angle)


def _omissions(request: ExportRequest) -> tuple[Omission, ...]:
    return ()


C = Exporter(target="a C compiler", write=_write, omissions=_omissions, run=_run, missing=missing)
"""The exporter of ``--to c``."""
