"""Work with a real camera and a real servo, or rehearse it without them.

One command with an action as its first word; each action is a function ``run(args)`` in a file
``_ACTION.py``.
"""

from __future__ import annotations

import argparse
from importlib import import_module

from servosight.app.arguments import add_force, add_seed, any_path, number
from servosight.app.completion import with_names
from servosight.models.base import InputError, did_you_mean

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
    "rehearse": "the same with a virtual servo and camera and a hidden effect",
}
STAMPS = ("exposure_start", "frame_end", "arrival")
KINDS = ("board", "dynamixel", "feetech", "maestro")


# One long list of options: none depends on another.
def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight bench``."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = "actions:\n" + "\n".join(f"  {name:9} {ACTIONS[name]}" for name in ACTIONS)
    with_names(
        parser.add_argument("action", metavar="ACTION", type=_action, help=", ".join(ACTIONS)),
        ACTIONS,
    )
    parser.add_argument(
        "excitation",
        metavar="EXCITATION",
        nargs="?",
        type=any_path,
        help="run: the command's CSV file, as `servosight excite` writes it",
    )
    parser.add_argument(
        "-o", "--output", metavar="REC|DIR|FILE", type=any_path, help="what to write"
    )
    parser.add_argument(
        "--arm", action="store_true", help="let the servo move: nothing moves without it"
    )
    parser.add_argument(
        "--yes", action="store_true", help="auto: go on without asking before each experiment"
    )
    devices = parser.add_argument_group("devices")
    devices.add_argument(
        "--servo", metavar="ADDRESS", help="such as dynamixel:/dev/ttyUSB0?id=1&baud=57600"
    )
    devices.add_argument(
        "--camera",
        metavar="ADDRESS",
        help="v4l2:/dev/video0?width=640&height=480, http://HOST:8080/?action=stream, rtsp://HOST/",
    )
    for name, unit, words in (
        ("exposure", "S", "the camera's exposure, where it does not say"),
        ("readout", "S", "from the first row's exposure to the last row's (rolling shutter)"),
    ):
        devices.add_argument(f"--{name}", metavar=unit, type=number, help=words)
    devices.add_argument(
        "--stamp", choices=STAMPS, help="what a frame's time stamp means, where it is known"
    )
    limits = parser.add_argument_group("limits that no command exceeds")
    for name, unit, words in (
        ("low", "DEG", "least angle (default -45)"),
        ("high", "DEG", "largest angle (default 45)"),
        ("neutral", "DEG", "angle at rest (default 0)"),
        ("rate", "DEG/S", "largest rate (default: jumps are allowed)"),
        ("acceleration", "DEG/S2", "largest acceleration (default: none)"),
        ("longest", "S", "longest command (default 120)"),
    ):
        limits.add_argument(f"--{name}", metavar=unit, type=number, help=words)
    rehearsal = parser.add_argument_group("rehearse")
    rehearsal.add_argument(
        "--kind", choices=KINDS, default="dynamixel", help="kind of servo (default dynamixel)"
    )
    rehearsal.add_argument(
        "--duration",
        metavar="S",
        type=number,
        default=10.0,
        help="duration of the command (default 10)",
    )
    rehearsal.add_argument(
        "--serve",
        action="store_true",
        help="only start the virtual servo and camera, for commands in another terminal",
    )
    add_seed(parser, default=1)
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Do what the action says."""
    import_module(f"servosight.app.commands.bench._{args.action}").run(args)


def _action(text: str) -> str:
    if text not in ACTIONS:
        meant = did_you_mean(text, ACTIONS)
        raise argparse.ArgumentTypeError(f"{text!r} is no action of the bench{meant}")
    return text


def wanted(args: argparse.Namespace, *names: str) -> None:
    """Raise InputError where an option that the action needs is missing."""
    for name in names:
        if getattr(args, name) is None:
            place = "-o FILE.png" if args.action == "target" else "-o FOLDER"
            given = {"output": place, "excitation": "EXCITATION"}.get(name, f"--{name} ADDRESS")
            raise InputError(
                f"bench {args.action}: needs {given}; add it, `servosight bench --help` explains it"
            )
