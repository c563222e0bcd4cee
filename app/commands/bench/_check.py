"""Check camera and servo, a line each: in order, or one sentence on how to correct it."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from servosight.app.arguments import refuse_without
from servosight.app.terminal import console

if TYPE_CHECKING:
    from rich.console import Console

    from servosight.bench.session import Line


def run(args: argparse.Namespace) -> None:
    """Check what is named; InputError where a line is not in order.

    Nothing moves without ``--arm``; with it the surface is looked for in the picture.
    """
    from servosight.app.commands.bench._devices import (
        limited_of,
        opened_camera,
        opened_servo,
        stated_of,
    )
    from servosight.bench.session import Line, check_camera, check_servo, check_surface
    from servosight.models.core import InputError

    if args.servo is None and args.camera is None:
        raise InputError("bench check: needs --camera ADDRESS or --servo ADDRESS; add one or both")
    if args.camera is None:
        refuse_without("--camera ADDRESS", stated_of(args))
    if args.servo is None:
        refuse_without("--servo ADDRESS", limited_of(args))
    if args.camera is None or args.servo is None:
        refuse_without("both --camera and --servo", {"--arm": args.arm})
    out = console(args)
    lines: list[Line] = []
    with ExitStack() as stack:
        camera = servo = None
        if args.camera is not None:
            camera = stack.enter_context(opened_camera(args))
            lines += check_camera(camera)
        if args.servo is not None:
            servo = stack.enter_context(opened_servo(args))
            lines += check_servo(servo)
        if camera is not None and servo is not None and all(line.good for line in lines):
            if args.arm:
                lines += check_surface(servo, camera)
            else:
                words = "not looked for; with --arm the servo turns by 5 deg to show it"
                lines.append(Line(what="surface", good=True, words=words))
    show_lines(out, lines)
    bad = [line.what for line in lines if not line.good]
    if bad:
        raise InputError(f"bench check: {', '.join(bad)} not in order; the lines above say how")


def show_lines(out: Console, lines: Sequence[Line]) -> None:
    """Print the lines of a check."""
    for line in lines:
        out.print("ok" if line.good else "NO", style="green" if line.good else "red", end="  ")
        out.print(f"{line.what}: {line.words}")
