"""Move the servo slowly about neutral, film it, and find sign, zero and pivot."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from servosight.app.terminal import console, progress

if TYPE_CHECKING:
    from servosight.scenarios.bench_experiment import Zero


def run(args: argparse.Namespace) -> None:
    """One slow run, tracked; what it shows of the mounting."""
    found(args)


def found(args: argparse.Namespace) -> Zero:
    """The same, and say it."""
    from servosight.app.commands.bench._devices import check_armed, opened_camera, opened_servo
    from servosight.scenarios.bench_experiment import find_zero

    check_armed(args)
    with (
        opened_camera(args) as camera,
        opened_servo(args) as servo,
        progress("bench") as show,
    ):
        zero = find_zero(servo, camera, args.output, progress=show, force=args.force)
    out = console(args)
    for words in zero.words:
        out.print(words)
    return zero
