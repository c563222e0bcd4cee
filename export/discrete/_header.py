"""``--to header``: the same coefficients as a C99 header, with the step that uses them."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from servosight.export.core import (
    Exporter,
    ExportRequest,
    ExportTrial,
    Response,
    mark_of,
    number,
    provenance_lines,
)
from servosight.export.discrete._coefficients import coefficients_of, omissions, sampled_trial
from servosight.models.core import write_text

COMPILER_TIME_S = 60.0
HEADER_TEXT = """/* {mark}
 *
{model}
 *
 * x(k) + a1 x(k-1) + a2 x(k-2) = b0 u(k-d) + b1 u(k-d-1) + b2 u(k-d-2), y = x + bias: command u and
 * angle y in degrees, sampled by {transform} every {step} s, dead time of d samples.
 * {name}_start() puts the servo at rest at a command; {name}_step() is called once a sample.
 */
#ifndef {upper}_H
#define {upper}_H

#define {upper}_SAMPLE_TIME_S {step}
#define {upper}_A1 ({a1})
#define {upper}_A2 ({a2})
#define {upper}_B0 ({b0})
#define {upper}_B1 ({b1})
#define {upper}_B2 ({b2})
#define {upper}_DELAY_SAMPLES {delay}
#define {upper}_BIAS_DEG ({bias})

typedef struct {{
    double command[{upper}_DELAY_SAMPLES + 3]; /* [0] is the newest */
    double angle[2];                           /* [0] is the newest, without bias */
}} {name}_state;

static inline void {name}_start({name}_state *state, double command_deg)
{{
    const double gain = ({upper}_B0 + {upper}_B1 + {upper}_B2) / (1.0 + {upper}_A1 + {upper}_A2);
    int i;
    for (i = 0; i < {upper}_DELAY_SAMPLES + 3; i++) {{
        state->command[i] = command_deg;
    }}
    state->angle[0] = state->angle[1] = gain * command_deg;
}}

static inline double {name}_step({name}_state *state, double command_deg)
{{
    const double *u = state->command + {upper}_DELAY_SAMPLES;
    double angle;
    int i;
    for (i = {upper}_DELAY_SAMPLES + 2; i > 0; i--) {{
        state->command[i] = state->command[i - 1];
    }}
    state->command[0] = command_deg;
    angle = {upper}_B0 * u[0] + {upper}_B1 * u[1] + {upper}_B2 * u[2]
        - {upper}_A1 * state->angle[0] - {upper}_A2 * state->angle[1];
    state->angle[1] = state->angle[0];
    state->angle[0] = angle;
    return angle + {upper}_BIAS_DEG;
}}

#endif
"""
PROGRAM = """#include "{file}"
#include <stdio.h>

int main(void)
{{
    {name}_state state;
    double command_deg;
    if (scanf("%lf", &command_deg) != 1) return 1;
    {name}_start(&state, command_deg);
    do printf("%.17g\\n", {name}_step(&state, command_deg));
    while (scanf("%lf", &command_deg) == 1);
    return 0;
}}
"""


def _write(request: ExportRequest, path: Path) -> None:
    found = coefficients_of(request)
    equation = found.equation
    text = HEADER_TEXT.format(
        mark=mark_of("header"),
        model="\n".join(f" * {line}" for line in provenance_lines(request)),
        transform=request.options.transform,
        name=request.name,
        upper=request.name.upper(),
        step=number(equation.sample_time_s),
        **{name: number(getattr(equation, name)) for name in ("a1", "a2", "b0", "b1", "b2")},
        delay=found.delay_samples,
        bias=number(found.bias_deg),
    )
    write_text(path, text)


def _run(request: ExportRequest, path: Path, trial: ExportTrial) -> Response:
    """Compile the header into a program that reads commands and prints angles."""
    time_s, command = sampled_trial(coefficients_of(request), trial)
    with tempfile.TemporaryDirectory() as folder:
        source, program = Path(folder) / "main.c", Path(folder) / "main"
        source.write_text(PROGRAM.format(file=path.absolute(), name=request.name))
        words = [str(shutil.which("cc")), "-std=c99", "-O1", "-o", str(program), str(source)]
        _finished(words)
        said = _finished([str(program)], "\n".join(map(repr, command.tolist())))
    return Response(time_s=time_s, angle_deg=np.array(said.split(), dtype=np.float64))


def _finished(words: list[str], given: str = "") -> str:
    done = subprocess.run(
        words, input=given, capture_output=True, text=True, timeout=COMPILER_TIME_S, check=False
    )
    if done.returncode != 0:
        raise RuntimeError(f"{Path(words[0]).name} refused the header: {done.stderr[:500]}")
    return done.stdout


def _missing() -> str | None:
    return None if shutil.which("cc") else "no C compiler (cc) was found"


HEADER = Exporter(
    target="a C compiler", write=_write, omissions=omissions, run=_run, missing=_missing
)
"""The exporter of ``--to header``."""
