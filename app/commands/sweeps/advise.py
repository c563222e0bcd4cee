"""Say which camera shows an effect of a given size, from the results of a sweep."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from servosight.app.arguments import add_force, add_json, any_path, number
from servosight.app.terminal import check_outputs, console, write_json

if TYPE_CHECKING:
    from servosight.scenarios.sweeps import Summary


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight advise``."""
    parser.add_argument(
        "--effect",
        metavar="ID",
        default="backlash",
        help="the effect to be found (default: backlash)",
    )
    parser.add_argument(
        "--size",
        metavar="X",
        type=_size,
        required=True,
        help="its size, in the unit of the sweep's axis (backlash: degrees of play)",
    )
    parser.add_argument(
        "--results",
        metavar="DIR",
        type=any_path,
        help="a sweep of your own: its folder, or the JSON of `servosight results` (default: the "
        "results of camera_for_backlash that come with the program)",
    )
    add_json(parser)
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Compare the smallest size that each camera shows with the size asked for."""
    from servosight.scenarios.sweeps import advise

    check_outputs(args)
    summary = _answers(args.results)
    answers = advise(summary.found, args.effect, args.size)
    out = console(args)
    mine = next(one for one in summary.found if one.effect == args.effect)
    out.print(
        f"{mine.what} of {args.size:g} {mine.unit}".rstrip()
        + f", by {summary.cells} recordings of the sweep {summary.name}:"
    )
    for answer in answers:
        share = ""
        if answer.share is not None and answer.enough != "perhaps":
            share = f"found in {100.0 * answer.share:.0f} %"
        out.print(f"  {answer.enough:9}{share:16}{answer.sentence}")
    best = [one for one in answers if one.enough == "yes"]
    if not best:
        out.print(
            "None of these is sure to be enough: a larger sweep or a better camera is needed."
        )
    write_json(
        args.json, {"schema": 1, "effect": args.effect, "size": args.size, "answers": answers}
    )


def _answers(path: Path | None) -> Summary:
    from servosight.scenarios.sweeps import SHIPPED, saved_answers, summary, with_facts

    if path is not None and path.is_dir():
        return summary(*with_facts(path))
    return saved_answers(path or SHIPPED)


def _size(text: str) -> float:
    value = number(text)
    if value <= 0.0:
        raise argparse.ArgumentTypeError(f"{text!r} is no size, expected a number above 0")
    return value
