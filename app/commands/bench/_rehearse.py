"""The whole bench without hardware: a virtual servo and camera on the wire, a hidden effect."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from servosight.app.arguments import refuse_with
from servosight.app.experiment import REPORT, check_written, diagnosed, write_found
from servosight.app.terminal import console, progress
from servosight.models.base import InputError
from servosight.scenarios.durations import REHEARSAL_S, check_duration

if TYPE_CHECKING:
    from servosight.scenarios.rehearsal import Rehearsal

RECORDING = "recording"
_EXPOSURE_S = 0.003
_SWITCH_S = 2e-4


def run(args: argparse.Namespace) -> None:
    """Check, run, track, diagnose; then say what was hidden."""
    if args.serve:
        _serve(args)
        return
    if args.output is None:
        raise InputError("bench rehearse: needs -o DIR; add it")
    duration_s = REHEARSAL_S if args.duration is None else args.duration
    check_duration(duration_s)
    from servosight.models.base import make_folder
    from servosight.scenarios.rehearsal import Rehearsal, rehearse, write_truth

    place = Path(args.output)
    make_folder(place)
    check_written(place, force=args.force)
    drawn = Rehearsal.drawn(args.seed, args.kind)
    out = console(args)
    out.print(
        f"1. A virtual servo ({args.kind}, on a pseudo-terminal) and a virtual camera (MJPEG on "
        f"the loopback interface) share a hidden clock error; seed {args.seed}."
    )
    with progress("running"):
        lines = rehearse(drawn, place / RECORDING, duration_s, force=args.force)
    for line in lines:
        out.print(f"   {line}")
    recording, result = diagnosed(place / RECORDING, "surface", out)
    write_found(place, result, [recording], args, out)
    write_truth(drawn, place / RECORDING)
    out.print(f"4. What was hidden: {', '.join(drawn.effects)}.")
    for name, value in drawn.truth()["parameters"].items():
        out.print(f"   {name} = {value:.4g}")
    out.print(f"5. Open {place / REPORT} in a browser.")


def _serve(args: argparse.Namespace) -> None:
    """Serve until Ctrl-C, then say what was hidden."""
    import sys
    import time

    words = {"-o": args.output, "--duration": args.duration, "--force": args.force}
    refuse_with("--serve", words)
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
