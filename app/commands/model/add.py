"""Add one effect to a model and fit it again."""

from __future__ import annotations

import argparse

from servosight.app.arguments import (
    add_force,
    add_json,
    add_model_output,
    add_plugins,
    add_recordings,
    any_path,
)
from servosight.app.completion import with_effects
from servosight.app.terminal import (
    check_outputs,
    console,
    next_command,
    progress,
    show_identification,
    write_json,
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight add``."""
    parser.add_argument("model", metavar="MODEL.toml", type=any_path, help="the model's card")
    with_effects(
        parser.add_argument("effect", metavar="ID", help="effect to add; see servosight effects")
    )
    add_recordings(parser)
    add_model_output(parser)
    add_json(parser)
    add_plugins(parser)
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Free the effect's parameters, fit, print, write the card."""
    from servosight.app.inputs import load
    from servosight.diagnose import add
    from servosight.models.core import Actuator, InputError
    from servosight.models.effects import catalogue, select

    check_outputs(args)
    effects = catalogue(args.plugin)
    select(effects, [args.effect])
    actuator = Actuator.load(args.model, effects)
    if args.effect in actuator.effects:
        raise InputError(
            f"{args.model}: key effects holds {args.effect!r} already, expected a new effect; "
            f"choose another of {', '.join(effects)}"
        )
    recordings = load(args.recordings, args)
    with progress(f"fitting with {args.effect}"):
        result = add(actuator, args.effect, recordings, catalogue=effects)
    if args.output is not None:
        result.actuator.save(args.output)
    values = result.to_dict()
    out = console(args)
    show_identification(out, values)
    write_json(args.json, values)
    if args.output is None:
        out.print("The card is unchanged; -o MODEL.toml keeps the new model.")
    else:
        out.print(next_command("compare", args.output, "ANOTHER_REC"))
