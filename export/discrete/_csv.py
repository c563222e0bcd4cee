"""``--to csv``: the coefficients of the paper's eq. 2 at a sample time, as a table."""

from __future__ import annotations

import csv
from pathlib import Path

from servosight.export.core import Exporter, ExportRequest, ExportTrial, Response, number
from servosight.export.discrete._coefficients import (
    Coefficients,
    coefficients_of,
    omissions,
    response_of,
    sampled_trial,
)
from servosight.models.core import write_text
from servosight.models.plant import Difference

NAMES = ("a1", "a2", "b0", "b1", "b2")


def _write(request: ExportRequest, path: Path) -> None:
    found = coefficients_of(request)
    equation = found.equation
    rows = [("sample_time_s", number(equation.sample_time_s), "s")]
    rows += [(name, number(getattr(equation, name)), "-") for name in NAMES]
    rows += [("delay_samples", str(found.delay_samples), "-")]
    rows += [("bias_deg", number(found.bias_deg), "deg")]
    body = "".join(",".join(row) + "\n" for row in rows)
    write_text(path, f"name,value,unit\n{body}")


def _read(path: Path) -> Coefficients:
    with path.open(encoding="utf-8", newline="") as file:
        values = {row["name"]: float(row["value"]) for row in csv.DictReader(file)}
    equation = Difference(values["sample_time_s"], *(values[name] for name in NAMES))
    return Coefficients(equation, int(values["delay_samples"]), values["bias_deg"])


def _run(request: ExportRequest, path: Path, trial: ExportTrial) -> Response:
    found = _read(path)
    return response_of(found, *sampled_trial(found, trial), trial)


CSV = Exporter(target="the difference equation", write=_write, omissions=omissions, run=_run)
"""The exporter of ``--to csv``."""
