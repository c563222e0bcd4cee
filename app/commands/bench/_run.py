"""Play a command on the servo, film it, and write the recording."""

from __future__ import annotations

import argparse

from servosight.app.terminal import console, next_command


def run(args: argparse.Namespace) -> None:
    """One run; a recording that broke off is kept, and the reason is the error."""
    from servosight.app.commands.bench._devices import check_armed, opened_camera, opened_servo
    from servosight.bench.session import run, run_words
    from servosight.models.core import InputError
    from servosight.models.excitation import Excitation

    command = Excitation.load(args.excitation)
    check_armed(args)
    with opened_camera(args) as camera, opened_servo(args) as servo:
        done = run(
            servo,
            camera,
            command.time_s,
            command.command_deg,
            args.output,
            source=str(args.excitation),
            force=args.force,
        )
    out = console(args)
    for line in run_words(done):
        out.print(line)
    if done.fault is not None:
        raise InputError(
            f"{args.output}: the run ended early and was kept: {done.fault.rstrip('.')}"
        )
    out.print(next_command("diagnose", args.output, "--auto"))
