"""Print or plot what a sweep found: errors and their lower bound, how often effects are named."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from servosight.app.arguments import add_force, add_json, any_path
from servosight.app.terminal import check_outputs, check_target, console, write_json

if TYPE_CHECKING:
    from servosight.scenarios.sweeps import Summary

LINES = 200
"""Settings that are printed; of more, nobody reads a table."""
USUAL = 0.5
"""A column is printed where at least this share of the settings has a value in it."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight results``."""
    parser.add_argument("folder", metavar="DIR", type=any_path, help="the folder of a sweep")
    add_json(parser)
    parser.add_argument(
        "--plot",
        metavar="FILE",
        type=any_path,
        help="plot it: .png, or .html for an interactive page",
    )
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Read the rows, group them by the axes, print or write."""
    from servosight.app.sweeps import draw, plot_kind
    from servosight.scenarios.sweeps import summary, with_facts

    if args.plot is not None:
        check_target(args.plot, plot_kind(args.plot), force=args.force)
    check_outputs(args)
    frame, facts = with_facts(args.folder)
    found = summary(frame, facts)
    out = console(args)
    out.print(found.headline)
    if found.about:
        out.print(found.about)
    for sentence in found.failures:
        out.print(sentence)
    out.print(_shown(found))
    for answer in found.found[:LINES]:
        out.print(answer.sentence)
    more = max(len(found.table), len(found.found)) - LINES
    if more > 0:
        out.print(f"... and {more} settings more: --json FILE writes all")
    if args.plot is not None:
        draw(found, args.plot)
        out.print(f"drawn: {args.plot}")
    write_json(args.json, found)


def _shown(found: Summary) -> str:
    """The table's first rows, without the errors of effects that only few settings hide."""
    from servosight.models.core import Table

    rows = found.table[:LINES]
    if not rows:
        return str(rows)
    names = list(rows[0])
    usual = [n for n in names if sum(row[n] is not None for row in rows) >= USUAL * len(rows)]
    return str(Table([{name: row[name] for name in usual} for row in rows]))
