"""What each action of the bench takes: a table of them, and the arguments in it."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial

from servosight.app.arguments import add_force, add_seed, any_path, number
from servosight.scenarios.durations import EXPERIMENT_S, REHEARSAL_S

Adder = Callable[[argparse.ArgumentParser], None]
STAMPS = ("exposure_start", "frame_end", "arrival")
KINDS = ("board", "dynamixel", "feetech", "maestro")
LIMITS = {
    "low": ("DEG", "least angle (default: -45)"),
    "high": ("DEG", "largest angle (default: 45)"),
    "neutral": ("DEG", "angle at rest (default: 0)"),
    "rate": ("DEG/S", "largest rate (default: jumps are allowed)"),
    "acceleration": ("DEG/S2", "largest acceleration (default: none)"),
    "longest": ("S", "longest command (default: 120)"),
}


def add_excitation(parser: argparse.ArgumentParser) -> None:
    """``EXCITATION``."""
    parser.add_argument(
        "excitation",
        metavar="EXCITATION",
        type=any_path,
        help="the command's CSV file, as `servosight excite` writes it",
    )


def add_output(
    parser: argparse.ArgumentParser, metavar: str, words: str, required: bool = True
) -> None:
    """``-o``."""
    parser.add_argument(
        "-o", "--output", metavar=metavar, type=any_path, required=required, help=words
    )


def add_servo(parser: argparse.ArgumentParser, required: bool = False) -> None:
    """``--servo ADDRESS``."""
    parser.add_argument(
        "--servo",
        metavar="ADDRESS",
        required=required,
        help="such as dynamixel:/dev/ttyUSB0?id=1&baud=57600",
    )


def add_camera(parser: argparse.ArgumentParser, required: bool = False) -> None:
    """``--camera ADDRESS``, and what is stated of that camera."""
    camera = parser.add_argument_group("camera")
    camera.add_argument(
        "--camera",
        metavar="ADDRESS",
        required=required,
        help="v4l2:/dev/video0?width=640&height=480, http://HOST:8080/?action=stream, rtsp://HOST/",
    )
    for name, words in (
        ("exposure", "the camera's exposure, where it does not say"),
        ("readout", "from the first row's exposure to the last row's (rolling shutter)"),
    ):
        camera.add_argument(f"--{name}", metavar="S", type=number, help=words)
    camera.add_argument(
        "--stamp", choices=STAMPS, help="what a frame's time stamp means, where it is known"
    )


def add_limits(parser: argparse.ArgumentParser, *names: str) -> None:
    """The limits of these names."""
    limits = parser.add_argument_group("limits that no command exceeds")
    for name in names:
        unit, words = LIMITS[name]
        limits.add_argument(f"--{name}", metavar=unit, type=number, help=words)


def add_arm(parser: argparse.ArgumentParser) -> None:
    """``--arm``."""
    parser.add_argument(
        "--arm", action="store_true", help="let the servo move: nothing moves without it"
    )


def add_yes(parser: argparse.ArgumentParser) -> None:
    """``--yes``."""
    parser.add_argument(
        "--yes", action="store_true", help="go on without asking before each further experiment"
    )


def add_duration(parser: argparse.ArgumentParser, default: float) -> None:
    """``--duration S``; without it None, so that a user's own can be told from the default."""
    parser.add_argument(
        "--duration",
        metavar="S",
        type=number,
        help=f"duration of the command (default: {default:g})",
    )


def add_virtual(parser: argparse.ArgumentParser) -> None:
    """``--kind`` and ``--serve``, of the virtual servo."""
    parser.add_argument(
        "--kind", choices=KINDS, default="dynamixel", help="kind of servo (default: dynamixel)"
    )
    parser.add_argument(
        "--serve",
        action="store_true",
        help="only start the virtual servo and camera, for commands in another terminal",
    )


_SERVO = partial(add_servo, required=True)
_CAMERA = partial(add_camera, required=True)
_RECORDING = partial(add_output, metavar="REC", words="the recording to write")
_LIMITS: Adder = lambda parser: add_limits(parser, *LIMITS)  # noqa: E731
# The others are what the wizard asks for.
_UNASKED: Adder = lambda parser: add_limits(parser, "neutral", "acceleration", "longest")  # noqa: E731

OPTIONS: dict[str, tuple[Adder, ...]] = {
    "wizard": (add_servo, add_yes, add_seed, add_force, add_camera, _UNASKED),
    "cameras": (add_camera,),
    "servos": (add_servo, _LIMITS),
    "check": (add_servo, add_arm, add_camera, _LIMITS),
    "zero": (_RECORDING, _SERVO, add_arm, add_force, _CAMERA, _LIMITS),
    "run": (add_excitation, _RECORDING, _SERVO, add_arm, add_force, _CAMERA, _LIMITS),
    "auto": (
        partial(add_output, metavar="DIR", words="folder for recordings, diagnosis and report"),
        partial(add_duration, default=EXPERIMENT_S),
        *(_SERVO, add_arm, add_yes, add_seed, add_force, _CAMERA, _LIMITS),
    ),
    "target": (
        partial(add_output, metavar="FILE.png", words="the page to write"),
        add_force,
    ),
    "firmware": (
        partial(add_output, metavar="DIR", words="folder for source and program"),
        add_servo,
        add_force,
    ),
    "rehearse": (
        partial(
            add_output,
            metavar="DIR",
            words="folder for recording, diagnosis and report",
            required=False,
        ),
        partial(add_duration, default=REHEARSAL_S),
        partial(add_seed, default=1),
        *(add_virtual, add_force),
    ),
}
"""By action, in the order of the help. What is not named here, an action refuses."""
