"""Work with a real camera and a real servo, or rehearse it without them.

One command with an action as its first word; each action is a function ``run(args)`` in a file
``_ACTION.py``, and a row in the table of ``_options.py``.
"""

from __future__ import annotations

import argparse
from importlib import import_module

from servosight.app.arguments import add_general
from servosight.app.commands.bench._options import OPTIONS

ACTIONS = {
    "wizard": "all steps, question by question, from plugging in to the report",
    "cameras": "list the cameras and their modes; with --camera, measure the frame rate",
    "servos": "list serial ports and kinds of servo; with --servo, ask it what it measures",
    "check": "check camera and servo, a line each; with --arm, look for the surface",
    "zero": "move slowly about neutral, film it, and find sign, zero and pivot",
    "run": "play EXCITATION, film it, write a recording",
    "auto": "check, zero, run, track and diagnose; asks before each further experiment",
    "target": "write a page to print to -o FILE.png: patterned discs and a protractor",
    "firmware": "compile the firmware of a board into -o DIR, and say how to write it there",
    "rehearse": "run, track and diagnose with a virtual servo and camera and a hidden effect",
}


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight bench``."""
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True)
    for name, words in ACTIONS.items():
        described = f"{words[0].upper()}{words[1:]}."
        action = actions.add_parser(name, help=words, description=described, allow_abbrev=False)
        add_general(action, argparse.SUPPRESS)
        for add in OPTIONS[name]:
            add(action)


def run(args: argparse.Namespace) -> None:
    """Do what the action says."""
    import_module(f"servosight.app.commands.bench._{args.action}").run(args)
