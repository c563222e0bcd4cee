"""Run a complete example: simulate a hidden effect, film it, track it, find it."""

from __future__ import annotations

import argparse
from pathlib import Path

from servosight.app.arguments import add_force, add_seed, any_path
from servosight.app.experiment import REPORT, check_written, diagnosed, write_found
from servosight.app.terminal import check_target, console, progress
from servosight.models.base import Kind

CARD = "model.toml"


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight demo``."""
    parser.add_argument(
        "-o",
        "--output",
        metavar="DIR",
        type=any_path,
        default=Path("out/demo"),
        help="folder for the recording, model, diagnosis and report (default: out/demo)",
    )
    add_seed(parser, default=1)
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Write recording/, model.toml, diagnosis.json and report.html."""
    from servosight.scenarios.draws import hidden
    from servosight.scenarios.produce import produce

    if args.output.is_dir():
        check_target(args.output / CARD, Kind.MODEL, force=args.force)
        check_written(args.output, force=args.force)
    out = console(args)
    place = args.output / "recording"
    scenario = hidden(args.seed)
    out.print(f"1. A servo with a hidden effect moves a fin and is filmed (seed {args.seed}).")
    with progress("filming") as show:
        produce(scenario, place, lambda done, total: show("frames", done, total), force=args.force)
    recording, result = diagnosed(place, "fin", out)
    result.actuator.save(args.output / CARD)
    write_found(args.output, result, [recording], args, out)
    out.print(f"4. What was hidden: {', '.join(scenario.effects)}.")
    out.print(f"5. Open {args.output / REPORT} in a browser.")
