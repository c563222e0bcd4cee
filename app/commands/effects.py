"""Show the catalogue of physical effects, or one of them in full."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from servosight.app.arguments import add_plugins
from servosight.app.output import console

if TYPE_CHECKING:
    from rich.console import Console

    from servosight.models.effect import Effect
    from servosight.models.parameter import Parameter


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight effects``."""
    parser.add_argument("effect", metavar="ID", nargs="?", help="one effect, in full")
    add_plugins(parser)


def run(args: argparse.Namespace) -> None:
    """Print each effect's equation, parameters, look, cause and how to confirm it."""
    from servosight.models.registry import catalogue, select

    effects = catalogue(args.plugin)
    names = list(effects) if args.effect is None else select(effects, [args.effect])
    out = console(args)
    for name in names:
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
    for label, text in lines.items():
        out.print(f"  {label:<12} {text}")
    out.print()


def _parameter(parameter: Parameter) -> str:
    neutral = parameter.neutral
    vanishes = "" if neutral is None else f", vanishes at {_plain(neutral)}"
    bounds = f"{_plain(parameter.low)} to {_plain(parameter.high)} {parameter.unit}"
    return f"{parameter.meaning} [{parameter.unit}], {bounds}{vanishes}"


def _plain(value: float) -> str:
    return "infinity" if math.isinf(value) else f"{value:g}"


def _suggest(out: Console, effects: Mapping[str, Effect]) -> None:
    out.print(
        f"{len(effects)} effects; your own come with --plugin FILE.py. Next: servosight diagnose "
        f"REC --auto"
    )
