"""Run a complete example: simulate a hidden effect, film it, track it, find it."""

from __future__ import annotations

import argparse
from pathlib import Path

from servosight.app.arguments import add_force, add_seed, any_path
from servosight.app.terminal import check_target, console, made, progress, show_diagnosis
from servosight.models.base import Kind

WRITTEN = {"model.toml": Kind.MODEL, "diagnosis.json": Kind.JSON, "report.html": Kind.HTML}


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
    from servosight.app.report import write_report
    from servosight.diagnose import diagnose
    from servosight.models.base import json_text, write_text
    from servosight.models.effects import catalogue
    from servosight.scenarios.draws import hidden
    from servosight.scenarios.produce import produce
    from servosight.sources import read

    card, diagnosis, report = (args.output / name for name in WRITTEN)
    if args.output.is_dir():
        for name, kind in WRITTEN.items():
            check_target(args.output / name, kind, force=args.force)
    out = console(args)
    place = args.output / "recording"
    scenario = hidden(args.seed)
    out.print(f"1. A servo with a hidden effect moves a fin and is filmed (seed {args.seed}).")
    with progress("filming") as show:
        produce(scenario, place, lambda done, total: show("frames", done, total), force=args.force)
    out.print("2. The camera measures the fin's angle.")
    with progress("tracking") as show:
        recording = read(place, progress=show)
    out.print("3. The model is compared with the measurement: what is missing?")
    with progress("diagnosing") as show:
        result = diagnose([recording], catalogue=catalogue(), auto=True, progress=show)
    values = result.to_dict()
    result.actuator.save(card)
    write_text(diagnosis, json_text(values))
    with progress("writing the report"):
        write_report(report, result, [recording], **made(args))
    show_diagnosis(out, values)
    out.print(f"4. What was hidden: {', '.join(scenario.effects)}.")
    out.print(f"5. Open {report} in a browser.")
