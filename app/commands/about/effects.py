"""Show the catalogue of physical effects, or all about one of them."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from servosight.app.arguments import add_force, add_json, add_plugins
from servosight.app.completion import with_effects
from servosight.app.terminal import check_outputs, console, write_json

if TYPE_CHECKING:
    from rich.console import Console

    from servosight.models.core import Parameter
    from servosight.models.effects import Effect


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight effects``."""
    with_effects(parser.add_argument("effect", metavar="ID", nargs="?", help="one effect, in full"))
    parser.add_argument("--list", action="store_true", help="one line for each effect")
    add_json(parser)
    add_plugins(parser)
    add_force(parser)


LABEL = 12
"""Width of the first column, but for longer names of parameters."""


def run(args: argparse.Namespace) -> None:
    """Print each effect's equation, parameters, look, cause and how to confirm it."""
    from servosight.models.effects import EffectTable, catalogue, effect_info, select

    check_outputs(args)
    effects = catalogue(args.plugin)
    names = list(effects) if args.effect is None else select(effects, [args.effect])
    write_json(args.json, EffectTable(effect_info(effects[name]) for name in names).to_dict())
    out = console(args)
    for name in names:
        if args.list:
            out.print(f"{name:<{max(map(len, names))}}  {effects[name].looks_like}")
        else:
            _show(out, effects[name])
    if args.effect is None:
        _suggest(out, effects)


def _show(out: Console, effect: Effect) -> None:
    out.print(f"{effect.id}  ({effect.place.value})")
    lines = {
        "equation": effect.equation,
        **{f"  {q.name}": _parameter(q) for q in effect.parameters},
        "looks like": effect.looks_like,
        "cause": effect.cause,
        "confirm": effect.confirm,
        "remedy": effect.remedy,
        "source": effect.source,
    }
    if effect.contains:
        lines["contains"] = f"{', '.join(effect.contains)}, at a limit of its parameters"
    width = max(LABEL, *map(len, lines))
    for label, text in lines.items():
        out.print(f"  {label:<{width}} {text}")
    out.print()


def _parameter(parameter: Parameter) -> str:
    neutral = parameter.neutral
    vanishes = "" if neutral is None else f", vanishes at {_plain(neutral)}"
    unit = parameter.suffix
    shown = f" [{unit.strip()}]" if unit else ""
    bounds = f"{_plain(parameter.low)} to {_plain(parameter.high)}{unit}"
    return f"{parameter.meaning}{shown}, {bounds}{vanishes}"


def _plain(value: float) -> str:
    return "infinity" if math.isinf(value) else f"{value:g}"


def _suggest(out: Console, effects: Mapping[str, Effect]) -> None:
    out.print(
        f"{len(effects)} effects; your own come with --plugin FILE.py. Next: servosight diagnose "
        f"REC --auto"
    )
