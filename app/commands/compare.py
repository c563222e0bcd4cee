"""Compare a model with recordings and show where it fails."""

from __future__ import annotations

import argparse

from servosight.app.arguments import (
    add_force,
    add_json,
    add_plugins,
    add_recordings,
    add_report,
    any_path,
)
from servosight.app.output import check_outputs, console, made, next_command, write_json
from servosight.app.progress import progress


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight compare``."""
    parser.add_argument("model", metavar="MODEL.toml", type=any_path, help="the model's card")
    add_recordings(parser)
    add_json(parser)
    add_report(parser)
    add_plugins(parser)
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Simulate, compare, print, write the JSON and the report."""
    from servosight.app.inputs import load
    from servosight.app.present import show_findings, show_where
    from servosight.diagnose import compare
    from servosight.models.core import Actuator
    from servosight.models.effects import catalogue

    check_outputs(args)
    effects = catalogue(args.plugin)
    actuator = Actuator.load(args.model, effects)
    recordings = load(args.recordings, args)
    with progress("comparing"):
        result = compare(actuator, recordings, catalogue=effects)
    values = result.to_dict()
    out = console(args)
    out.print(f"{result.headline}. {result.summary}")
    show_findings(out, values["findings"], values["sentences"][0])
    if not result.explained:
        show_where(out, values["where"], "where the model fails")
    for warning in values["warnings"]:
        out.print(f"note: {warning}")
    if args.report is not None:
        from servosight.app.report import write_report

        with progress("writing the report"):
            write_report(args.report, result, recordings, effects, **made(args))
        out.print(f"report: {args.report}")
    write_json(args.json, values)
    out.print(next_command("diagnose", *args.recordings, "--auto"))
