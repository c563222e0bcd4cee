"""Make a synthetic recording: a servo simulated in MuJoCo, its video, its true values."""

from __future__ import annotations

import argparse
from dataclasses import replace

from servosight.app.arguments import add_force, add_seed, any_path, identifiers
from servosight.app.completion import with_effects
from servosight.app.terminal import console, next_command, progress


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight simulate``."""
    parser.add_argument(
        "scenario",
        metavar="SCENARIO.toml",
        nargs="?",
        type=any_path,
        help="a scenario file (default: the standard scenario)",
    )
    with_effects(
        parser.add_argument(
            "--effect",
            metavar="ID,ID",
            action="extend",
            type=identifiers,
            default=[],
            help="hide these effects in the simulated servo (may be repeated)",
        )
    )
    parser.add_argument(
        "--set",
        metavar="ID.param=VALUE",
        action="append",
        default=[],
        help="set a parameter of an effect, such as backlash.gap=1.5, which adds the effect; or of "
        "the servo itself: k, T, xi or bias (may be repeated)",
    )
    parser.add_argument(
        "--video", action="store_true", help="film the servo: write a video instead of angles"
    )
    words = "seed of the random numbers (default: the scenario's)"
    add_seed(parser, default=None, words=words)
    parser.add_argument(
        "-o", "--output", metavar="REC", type=any_path, required=True, help="folder to write"
    )
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Simulate, film and write, completely or not at all."""
    from servosight.scenarios.produce import produce
    from servosight.scenarios.scenario import Scenario, parse_settings, with_effects

    scenario = Scenario() if args.scenario is None else Scenario.load(args.scenario)
    if args.seed is not None:
        scenario = replace(scenario, seed=args.seed)
    if args.video:
        scenario = replace(scenario, video=True)
    if args.effect or args.set:
        scenario = with_effects(scenario, args.effect, parse_settings(args.set))
    with progress("simulating") as show:
        produce(
            scenario,
            args.output,
            lambda done, total: show("frames", done, total),
            force=args.force,
        )
    out = console(args)
    out.print(
        f"{args.output}: {scenario.duration_s:g} s, seed {scenario.seed}, hidden: "
        f"{', '.join(scenario.effects) or 'nothing'}"
    )
    out.print(next_command("diagnose", args.output, "--auto"))
