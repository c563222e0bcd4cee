"""Make a synthetic recording: the twin in MuJoCo, filmed, with its truth beside it."""

from __future__ import annotations

import argparse
from pathlib import Path

from servosight.app.arguments import add_seed, setting
from servosight.app.output import console, progress

FILES = (
    "recording.toml",
    "command.csv",
    "angle.csv",
    "video.mkv",
    "frames.csv",
    "truth.toml",
    "scenario.toml",
)
"""What a synthetic recording may consist of; a folder with more than this is not replaced."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight simulate``."""
    parser.add_argument(
        "scenario", metavar="SCENARIO.toml", nargs="?", type=Path, help="default: the standard one"
    )
    parser.add_argument(
        "--effect",
        metavar="ID",
        action="append",
        default=[],
        help="hide this effect in the twin (may be repeated)",
    )
    parser.add_argument(
        "--set",
        metavar="ID.param=VALUE",
        type=setting,
        action="append",
        default=[],
        help="with this strength, such as backlash.gap=1.5",
    )
    add_seed(parser, default=None)
    parser.add_argument(
        "-o", "--output", metavar="REC", type=Path, required=True, help="folder to write"
    )


def run(args: argparse.Namespace) -> None:
    """Simulate, film and write, whole or not at all."""
    from servosight.models.atomic import new_folder
    from servosight.scenarios.produce import produce
    from servosight.scenarios.scenario import Scenario

    scenario = Scenario() if args.scenario is None else Scenario.load(args.scenario)
    if args.seed is not None:
        scenario = scenario.with_seed(args.seed)
    if args.effect or args.set:
        strengths: dict[str, dict[str, float]] = {name: {} for name in args.effect}
        for effect, parameter, value in args.set:
            strengths.setdefault(effect, {})[parameter] = value
        scenario = scenario.with_effects(strengths)
    with progress("simulating"), new_folder(args.output, FILES) as fresh:
        produce(scenario, fresh)
    out = console(args)
    out.print(f"{args.output}: written")
    out.print(f"Next: servosight diagnose {args.output} --auto")
