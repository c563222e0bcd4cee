"""Convert a log of another program: CSV, JSON, Parquet, .mat, ROS 2 bag, ULog, LeRobot."""

from __future__ import annotations

import argparse

from servosight.app.arguments import add_force, add_pulse, any_path, number, whole
from servosight.app.terminal import console, next_command


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight import``."""
    parser.add_argument("source", metavar="SOURCE", type=any_path, help="the log")
    parser.add_argument(
        "-o", "--output", metavar="REC", type=any_path, required=True, help="folder to write"
    )
    parser.add_argument(
        "--map",
        metavar="QUANTITY=COLUMN[:UNIT]",
        action="append",
        default=[],
        help="which column is the time, command, angle or sigma, such as angle=pos:rad; "
        "command_time is the clock of a command with rows of its own",
    )
    parser.add_argument(
        "--unit", help="unit of command, angle and sigma where none is named (default: deg)"
    )
    parser.add_argument(
        "--unit-scale",
        metavar="DEG",
        type=number,
        help="degrees that one unit of the output is shown as, where the output is not an angle",
    )
    parser.add_argument(
        "--part", metavar="N", type=whole, default=0, help="which episode of a data set, from 0"
    )
    parser.add_argument(
        "--command",
        dest="command_file",
        metavar="FILE",
        type=any_path,
        help="a second table, on the same clock, that has the command",
    )
    parser.add_argument(
        "--angle-of",
        choices=("surface", "sensor"),
        help="what measured the angle: something at the surface, or the servo's own sensor, with "
        "which its loop compares the command (default: surface; bam and LeRobot: sensor)",
    )
    add_pulse(parser)
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Read, check and write; say what was cut."""
    from servosight.identify.problem.samples import usable_views
    from servosight.models.base import InputError, check_folder
    from servosight.models.io import FILES, save_recording
    from servosight.models.io.importers import parse_map
    from servosight.sources import Options, read_log

    if args.unit_scale == 0.0:
        raise InputError("--unit-scale 0: expected degrees in one unit, so give another number")
    check_folder(args.output, FILES, force=args.force)
    parse_map(args.map)  # what is wrong with it is said before anything is read
    columns = dict(word.split("=", 1) for word in args.map)
    options = Options(
        columns,
        args.unit,
        args.unit_scale,
        args.deg_per_us,
        args.neutral_us,
        args.part,
        args.command_file,
        args.angle_of,
    )
    recording = read_log(args.source, options)
    save_recording(recording, args.output, force=args.force)
    out = console(args)
    for note in recording.notes:
        out.print(f"note: {note}")
    if "unit_scale" in recording.details:
        scale, unit = recording.details["unit_scale"], recording.details["unit"]
        out.print(f"note: one {unit} of the output is shown as {scale:g} deg")
    if recording.side == "sensor" and args.angle_of is None:
        out.print(
            "note: the angle is taken as the reading of the servo's own sensor; if it was measured "
            "at the surface, give --angle-of surface"
        )
    usable = usable_views([recording])[0][0]
    wrong = recording.time_s.size - usable.time_s.size
    left_out = "1 read error or old value" if wrong == 1 else f"{wrong} read errors and old values"
    out.print(
        f"{args.output}: {recording.time_s.size} samples over {recording.duration_s:.2f} s, moved "
        f"{usable.moved_range_deg:.4g} deg" + (f" without {left_out}" if wrong else "")
    )
    out.print(next_command("diagnose", args.output, "--auto"))
