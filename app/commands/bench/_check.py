"""Check camera and servo, a line each: in order, or one sentence on how to correct it."""

from __future__ import annotations

import argparse
from contextlib import ExitStack

from servosight.app.output import console


def run(args: argparse.Namespace) -> None:
    """Check what is named; nothing moves. InputError where a line is not in order."""
    from servosight.app.commands.bench import wanted
    from servosight.app.commands.bench._devices import opened_camera, opened_servo
    from servosight.bench.session import check_camera, check_servo
    from servosight.models.core import InputError

    if args.servo is None:
        wanted(args, "camera")
    out = console(args)
    lines = []
    with ExitStack() as stack:
        if args.camera is not None:
            lines += check_camera(stack.enter_context(opened_camera(args)))
        if args.servo is not None:
            lines += check_servo(stack.enter_context(opened_servo(args)))
    for line in lines:
        mark = "[green]ok[/]  " if line.good else "[red]NO[/]  "
        out.print(mark if out.is_terminal else ("ok  " if line.good else "NO  "), end="")
        out.print(f"{line.what}: {line.words}")
    bad = [line.what for line in lines if not line.good]
    if bad:
        raise InputError(f"bench check: {', '.join(bad)} not in order; the lines above say how")
