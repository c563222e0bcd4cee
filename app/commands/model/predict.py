"""Run a model on a command, or on the command of a recording."""

from __future__ import annotations

import argparse

from servosight.app.arguments import add_force, add_plugins, add_pulse, any_path
from servosight.app.output import check_outputs, console
from servosight.models.base import Kind


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight predict``."""
    parser.add_argument("model", metavar="MODEL.toml", type=any_path, help="the model's card")
    parser.add_argument(
        "command_file",
        metavar="COMMAND.csv|REC",
        type=any_path,
        help="time_s,command_deg, each held until the next; or a recording",
    )
    parser.add_argument(
        "-o", "--output", metavar="angle.csv", type=any_path, required=True, help="file to write"
    )
    add_pulse(parser)
    add_plugins(parser)
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Simulate and write ``time_s,angle_deg``; for a recording, print the error as well."""
    import numpy as np

    from servosight.app.inputs import is_command, load
    from servosight.models.core import Actuator
    from servosight.models.effects import catalogue
    from servosight.models.excitation import Excitation
    from servosight.models.io import write_angle

    check_outputs(args, Kind.TABLE)
    effects = catalogue(args.plugin)
    actuator = Actuator.load(args.model, effects)
    out = console(args)
    if is_command(args.command_file):
        rows = Excitation.load(args.command_file)
        time_s = rows.time_s
        angle = actuator.predict(time_s=time_s, command_deg=rows.command_deg, catalogue=effects)
        words = "from rest"
    else:
        recording = load([args.command_file], args)[0]
        time_s = recording.time_s
        angle = actuator.predict(recording, catalogue=effects)
        error_deg = float(np.sqrt(np.mean((angle - recording.angle_deg) ** 2)))
        words = f"rms difference from the measured angle {error_deg:.3g} deg"
    write_angle(args.output, time_s, angle, None)
    out.print(
        f"{args.output}: {time_s.size} samples, {angle.min():.4g} to {angle.max():.4g} deg, {words}"
    )
