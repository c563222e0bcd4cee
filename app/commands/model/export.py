"""Write a model for other programs, and compare what they make of it."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from servosight.app.arguments import (
    add_force,
    add_json,
    add_plugins,
    add_pulse,
    any_path,
    number,
)
from servosight.app.completion import with_names
from servosight.app.terminal import check_outputs, console, write_json
from servosight.export.kinds import KINDS, kind_named

if TYPE_CHECKING:
    from servosight.export.core import ExportResult


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight export``."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    width = max(map(len, KINDS))
    parser.epilog = "kinds:\n" + "\n".join(
        f"  {name:{width}}  {kind.summary}" for name, kind in KINDS.items()
    )
    parser.add_argument("model", metavar="MODEL.toml", type=any_path, help="the model's card")
    with_names(
        parser.add_argument("--to", metavar="KIND", required=True, help="what to write: see below"),
        KINDS,
    )
    parser.add_argument(
        "-o", "--output", metavar="FILE", type=any_path, required=True, help="file to write"
    )
    parser.add_argument(
        "--on",
        metavar="REC",
        type=any_path,
        help="recording to compare on (default: a standard command)",
    )
    parser.add_argument(
        "--sample-time",
        metavar="S",
        type=number,
        help="of a difference equation (default 0.01), or time step of the simulator",
    )
    parser.add_argument(
        "--transform",
        metavar="NAME",
        default="tustin",
        help="how it is sampled: tustin (default), zoh or matched",
    )
    parser.add_argument(
        "--stiffness",
        metavar="NM_RAD",
        type=number,
        default=1.0,
        help="of the position loop, for torques in N m (default 1)",
    )
    add_json(parser)
    add_pulse(parser)
    add_plugins(parser)
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Write, run in the target, compare; print what was left out and how much that matters."""
    from servosight.app.inputs import load
    from servosight.export.core import ExportOptions, export_model
    from servosight.models.core import Actuator
    from servosight.models.effects import catalogue

    check_outputs(args, kind_named(args.to).file)
    effects = catalogue(args.plugin)
    actuator = Actuator.load(args.model, effects)
    options = ExportOptions(
        sample_time_s=args.sample_time,
        transform=args.transform,
        stiffness_nm_rad=args.stiffness,
    )
    on = None if args.on is None else load([args.on], args)[0]
    result = export_model(actuator, args.to, args.output, effects=effects, options=options, on=on)
    write_json(args.json, result.to_dict())
    out = console(args)
    for line in lines_of(result):
        out.print(line)


def lines_of(result: ExportResult) -> list[str]:
    """What the terminal shows of an export."""
    lines = [f"{result.file}: written for {result.target}"]
    if result.not_run is not None:
        lines.append(f"not run: {result.not_run}")
    elif result.difference_rms_deg is not None:
        lines.append(
            f"run on {result.trial}: differs from the model by {result.difference_rms_deg:.3g} deg "
            f"rms, {result.difference_max_deg:.3g} deg at most"
        )
    if result.target_rmse_deg is not None:
        lines.append(
            f"rms error against the measured angle: {result.target_rmse_deg:.3g} deg, of the model "
            f"{result.model_rmse_deg:.3g} deg"
        )
    for one in result.omissions:
        how = "left out" if one.approximation is None else f"as {one.approximation}"
        lines.append(f"{one.effect}: {how}; without it {one.without_deg:.3g} deg rms")
    return [*lines, *(f"note: {note}" for note in result.notes)]
