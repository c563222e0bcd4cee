"""Move the servo slowly about neutral, film it, and find sign, zero and pivot."""

from __future__ import annotations

import argparse

from servosight.app.output import console
from servosight.app.progress import progress


def run(args: argparse.Namespace) -> None:
    """One slow run, tracked; what it shows of the mounting."""
    from servosight.app.commands.bench import wanted

    wanted(args, "output", "servo", "camera")
    from servosight.app.commands.bench._devices import (
        check_armed,
        limits_of,
        opened_camera,
        opened_servo,
    )
    from servosight.bench.session import run
    from servosight.models.core import InputError
    from servosight.scenarios.trial import zero_command, zero_of
    from servosight.sources import geometry_of, read

    check_armed(args)
    limits = limits_of(args)
    command = zero_command(limits)
    with opened_camera(args) as camera, opened_servo(args) as servo:
        done = run(
            servo, camera, command.time_s, command.command_deg, args.output, force=args.force
        )
    if done.fault is not None:
        raise InputError(f"{args.output}: the run ended early and was kept: {done.fault}")
    with progress("tracking") as show:
        recording = read(args.output, progress=show)
    geometry = geometry_of(recording)
    zero = zero_of(recording, limits.neutral_deg)
    out = console(args)
    way = "counter-clockwise" if zero.gain > 0.0 else "clockwise"
    out.print(f"a positive command turns the surface {way} as seen, by {zero.gain:.3f} deg a deg")
    out.print(f"at neutral it stands {zero.neutral_deg:+.3f} deg from where the film began")
    out.print(
        f"rising and falling command differ by {zero.hysteresis_deg:.3f} deg: lag, play, friction"
    )
    if geometry is not None:
        x, y = geometry.pivot_px
        out.print(f"the hinge is seen at {x:.1f},{y:.1f} px")
