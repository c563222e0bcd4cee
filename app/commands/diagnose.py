"""Find out which physical effects the linear model misses."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from servosight.app.arguments import (
    add_json,
    add_model_output,
    add_plugins,
    add_recordings,
    add_report,
    add_seed,
    not_negative,
)
from servosight.app.output import check_outputs, console, next_command, progress, write_json


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight diagnose``."""
    add_recordings(parser)
    parser.add_argument(
        "--validate",
        metavar="REC",
        type=Path,
        action="append",
        default=[],
        help="recording that is only scored (may be repeated); else blocks of time are held out",
    )
    parser.add_argument(
        "--auto", action="store_true", help="add the best effect, refit, repeat, up to the floor"
    )
    parser.add_argument(
        "--tolerance",
        metavar="DEG",
        type=not_negative,
        help="error that no model is asked to beat (default: 0.05 %% of the moved range)",
    )
    add_seed(parser)  # kept for scripts: the climb has no chance in it
    add_model_output(parser)
    add_json(parser)
    add_report(parser)
    add_plugins(parser)


def run(args: argparse.Namespace) -> None:
    """Diagnose, print, write the card, the JSON and the report."""
    from servosight.app.present import show_diagnosis
    from servosight.app.sources import load
    from servosight.diagnose.diagnose import diagnose
    from servosight.models.registry import catalogue

    check_outputs(args)
    effects = catalogue(args.plugin)
    recordings = load(args.recordings, args)
    validate = load(args.validate, args)
    with progress("diagnosing") as show:
        result = diagnose(
            recordings,
            validate,
            catalogue=effects,
            auto=args.auto,
            tolerance=args.tolerance,
            progress=show,
        )
    if args.output is not None:
        result.actuator.save(args.output)
    values = result.to_json()
    out = console(args)
    show_diagnosis(out, values)
    if args.report is not None:
        from servosight.app.report import write_report

        write_report(args.report, result, [*recordings, *validate])
        out.print(f"report: {args.report}")
    write_json(args.json, values)
    out.print(next_command(*_next(args, values)))


def _next(args: argparse.Namespace, values: dict[str, Any]) -> list[object]:
    """What to type now: climb, then look at the report, keep the model, try it on another run."""
    again: list[object] = ["diagnose", *args.recordings, "--auto"]
    again += [word for path in args.validate for word in ("--validate", path)]
    again += [word for path in args.plugin for word in ("--plugin", path)]
    if not args.auto and values["verdict"] != "no_effect_missing":
        return again
    if args.report is None:
        return [*again, "--report", "report.html"]
    if args.output is None:
        return [*again, "-o", "model.toml"]
    return ["compare", args.output, "ANOTHER_REC"]
