"""Print what a sweep found: errors beside their limit, names by strength; or draw it."""

from __future__ import annotations

import argparse

from servosight.app.arguments import add_force, add_json, any_path
from servosight.app.output import check_outputs, console, write_json


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight results``."""
    parser.add_argument("folder", metavar="DIR", type=any_path, help="the folder of a sweep")
    add_json(parser)
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Read the rows, group them by the axes, print or write."""
    from servosight.scenarios.sweeps import summary, with_facts

    check_outputs(args)
    frame, facts = with_facts(args.folder)
    found = summary(frame, facts)
    out = console(args)
    out.print(found.headline)
    for sentence in found.failures:
        out.print(sentence)
    out.print(str(found.table))
    write_json(args.json, found)
