"""Write the report of a saved diagnosis or comparison."""

from __future__ import annotations

import argparse

from servosight.app.arguments import add_force, add_plugins, add_pulse, any_path
from servosight.app.terminal import check_target, console, made, progress
from servosight.models.base import Kind


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight report``."""
    parser.add_argument(
        "result",
        metavar="DIAGNOSIS.json",
        type=any_path,
        help="what --json of diagnose or compare wrote",
    )
    parser.add_argument(
        "recordings",
        metavar="REC",
        nargs="*",
        default=[],
        type=any_path,
        help="its recordings, in the same order (default: the paths saved in it)",
    )
    parser.add_argument(
        "-o", "--output", metavar="REPORT.html", type=any_path, required=True, help="page to write"
    )
    add_pulse(parser)
    add_plugins(parser)
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Read the result, simulate its models on its recordings, write the page."""
    import servosight
    from servosight.app.inputs import load
    from servosight.app.report import write_report
    from servosight.diagnose import Comparison, Diagnosis
    from servosight.diagnose.change import ServoChange
    from servosight.models.core import InputError
    from servosight.models.effects import catalogue

    check_target(args.output, Kind.HTML, force=args.force)
    result = servosight.load(args.result)
    if not isinstance(result, Diagnosis | Comparison | ServoChange):
        raise InputError(
            f"{args.result}: holds no diagnosis and no comparison, expected the JSON of one; write "
            f"it with `servosight diagnose REC --json diagnosis.json`"
        )
    if not args.recordings and result.moved:
        raise InputError(
            f"{args.result}: its recording {result.moved[0]} is not there, expected it where it "
            f"was; name the recordings: `servosight report {args.result} REC -o {args.output}`"
        )
    with progress("simulating"):
        write_report(
            args.output,
            result,
            load(args.recordings, args) or None,
            catalogue(args.plugin),
            **made(args),
        )
    console(args).print(f"{args.output}: written")
