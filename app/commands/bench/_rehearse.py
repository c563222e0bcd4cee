"""The whole bench without hardware: a virtual servo and camera on the wire, a hidden effect."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from servosight.app.terminal import check_target, console, made, progress, show_diagnosis
from servosight.models.base import InputError, Kind

if TYPE_CHECKING:
    from servosight.scenarios.rehearsal import Rehearsal

RECORDING = "recording"
WRITTEN = {"diagnosis.json": Kind.JSON, "report.html": Kind.HTML}
_EXPOSURE_S = 0.003
_LONGEST_S = 60.0
_SWITCH_S = 2e-4


def run(args: argparse.Namespace) -> None:
    """Check, run, track, diagnose; then say what was hidden."""
    from servosight.app.commands.bench import wanted

    if args.serve:
        _serve(args)
        return
    wanted(args, "output")
    if not 4.0 <= args.duration <= _LONGEST_S:
        raise InputError(
            f"--duration: {args.duration:g} is out of range, expected 4 to {_LONGEST_S:g} seconds"
        )
    from servosight.app.report import write_report
    from servosight.diagnose import diagnose
    from servosight.models.base import json_text, make_folder, write_text
    from servosight.models.effects import catalogue
    from servosight.scenarios.rehearsal import Rehearsal, rehearse, write_truth
    from servosight.sources import read

    place = Path(args.output)
    make_folder(place)
    for name, kind in WRITTEN.items():
        check_target(place / name, kind, force=args.force)
    drawn = Rehearsal.drawn(args.seed, args.kind)
    out = console(args)
    out.print(
        f"1. A virtual servo ({args.kind}, on a pseudo-terminal) and a virtual camera (MJPEG on "
        f"the loopback interface) share a hidden clock error; seed {args.seed}."
    )
    with progress("running"):
        lines = rehearse(drawn, place / RECORDING, args.duration, force=args.force)
    for line in lines:
        out.print(f"   {line}")
    out.print("2. The camera measures the surface's angle.")
    with progress("tracking") as show:
        recording = read(place / RECORDING, progress=show)
    out.print("3. The model is compared with the measurement: what is missing?")
    with progress("diagnosing") as show:
        result = diagnose([recording], catalogue=catalogue(), auto=True, progress=show)
    values = result.to_dict()
    write_text(place / "diagnosis.json", json_text(values))
    with progress("writing the report"):
        write_report(place / "report.html", result, [recording], **made(args))
    show_diagnosis(out, values)
    write_truth(drawn, place / RECORDING)
    out.print(f"4. What was hidden: {', '.join(drawn.effects)}.")
    for name, value in drawn.truth()["parameters"].items():
        out.print(f"   {name} = {value:.4g}")
    out.print(f"5. Open {place / 'report.html'} in a browser.")


def _serve(args: argparse.Namespace) -> None:
    """Serve until Ctrl-C, then say what was hidden."""
    import sys
    import time

    from servosight.scenarios.rehearsal import Rehearsal, served_bench

    sys.setswitchinterval(_SWITCH_S)  # drawing must not keep the servo from answering in time
    drawn = Rehearsal.drawn(args.seed, args.kind)
    out = console(args)
    with served_bench(drawn) as (servo, camera):
        out.print(f'--servo "{servo}" --camera "{camera}" --exposure {_EXPOSURE_S:g}')
        if args.kind == "feetech":
            out.print("note: a Feetech servo has no light that another program could switch")
        out.print("Ctrl-C ends it and says what is hidden.")
        sys.stdout.flush()  # whoever reads the addresses waits for them
        try:
            while True:
                time.sleep(0.2)
        except KeyboardInterrupt:
            out.print(f"hidden: {', '.join(f'{k} = {v:.4g}' for k, v in _values(drawn))}")
            raise


def _values(drawn: Rehearsal) -> list[tuple[str, float]]:
    return list(drawn.truth()["parameters"].items())
