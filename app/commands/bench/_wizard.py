"""From plugging in to the report, question by question."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from servosight.app.commands.bench import _questions as questions
from servosight.app.commands.bench._options import LIMITS
from servosight.models.base import InputError
from servosight.scenarios.durations import EXPERIMENT_S, LONGEST_S, SHORTEST_S

if TYPE_CHECKING:
    from servosight.bench.camera import FoundCamera

ARM = "arm"
FOLDER = "bench-results"
_KINDS = {
    "dynamixel": "Dynamixel X series, on a U2D2 or another half-duplex adapter",
    "feetech": "Feetech STS or SMS series, on a URT-1 or another half-duplex adapter",
    "maestro": "hobby servo on a Pololu Maestro",
    "board": "hobby servo on an Arduino-class board with servosight's firmware",
}
_KEYS: dict[str, tuple[tuple[str, str, str, float, float], ...]] = {
    "dynamixel": (
        ("id", "1", "Which ID does the servo have? The factory setting is 1.", 0, 252),
        ("baud", "57600", "Which baud rate? The factory setting is 57600.", 9600, 4_500_000),
    ),
    "feetech": (
        ("id", "1", "Which ID does the servo have? The factory setting is 1.", 0, 253),
        ("baud", "1000000", "Which baud rate? The factory setting is 1000000.", 9600, 1_000_000),
    ),
    "maestro": (
        ("channel", "0", "Which channel of the Maestro drives it?", 0, 23),
        ("deg_per_us", "0.09", "By how many degrees does a microsecond of pulse turn it?", 0.01, 1),
    ),
    "board": (
        ("deg_per_us", "0.09", "By how many degrees does a microsecond of pulse turn it?", 0.01, 1),
    ),
}
_LIGHTS = {"dynamixel": ("led", "dtr", "rts"), "feetech": ("dtr", "rts")}
_NUMBERS = ("exposure", "readout", *LIMITS, "duration", "seed")
"""Options of ``bench auto`` that take a number."""
_NONE = "none"
_USUAL_HZ = 60.0


def run(args: argparse.Namespace) -> None:
    """Ask, check, move, film, diagnose; ends at any question."""
    questions.check_terminal("bench wizard")
    print(
        "This leads from plugging in to the report. An empty answer takes the value in brackets, "
        f"{questions.END} ends it at any question, and Ctrl-C at any time: the servo then goes to "
        "neutral and its torque off."
    )
    # What is asked for later.
    args.low = args.high = args.rate = args.duration = args.output = None
    args.arm = False
    try:
        _servo(args)
        _camera(args)
        _limits(args)
        _check(args)
        _experiment(args)
    except questions.Ended:
        print("Ended; nothing moves.")


def _servo(args: argparse.Namespace) -> None:
    """The servo's address, until a servo answers there."""
    from servosight.app.commands.bench import _servos
    from servosight.bench.session import serial_ports

    print("\n1. The servo. Give it its own power supply, and connect its adapter by USB.")
    while True:
        if args.servo is None:
            words = list(_KINDS.values())
            picked = questions.choose("Which servo is it?", words)
            kind = list(_KINDS)[words.index(picked)]
            port = questions.choose(
                "Which port is it on?", serial_ports(), "a port such as /dev/ttyUSB0"
            )
            keys = []
            for key, default, question, least, most in _KEYS[kind]:
                whole = "." not in default
                keys.append(
                    f"{key}={questions.number(question, default, least, most, whole=whole)}"
                )
            if kind == "maestro":
                crc = questions.agree('Is "Enable CRC" set in the Maestro Control Center?')
                keys.append(f"crc={'true' if crc else 'false'}")
            keys += _light(kind)
            args.servo = f"{kind}:{port}?{'&'.join(keys)}"
        if _worked(_servos.run, args):
            return
        args.servo = None


def _light(kind: str) -> list[str]:
    """The key of the light that puts command and video on one clock; none where there is none."""
    if kind == "maestro":
        picked = questions.ask(
            "On which channel is an LED that the camera sees?",
            _NONE,
            lambda word: (
                None
                if word == _NONE or (word.isascii() and word.isdigit() and int(word) <= 23)
                else f"type a channel from 0 to 23, or {_NONE}"
            ),
        )
        return [] if picked == _NONE else [f"light_channel={picked}"]
    if kind not in _LIGHTS:
        return []
    words = (*_LIGHTS[kind], _NONE)
    picked = questions.ask(
        f"Which light does the camera see (docs/bench.md): {', '.join(words)}?",
        _NONE,
        lambda word: None if word in words else f"type one of {', '.join(words)}",
    )
    return [] if picked == _NONE else [f"light={picked}"]


def _camera(args: argparse.Namespace) -> None:
    """The camera's address, until frames come from there."""
    from servosight.app.commands.bench import _cameras
    from servosight.bench.camera import list_cameras

    print(
        "\n2. The camera. Put it on the axis of rotation, with the surface over a third of the "
        "picture or more, and two lamps of direct current at the sides."
    )
    while True:
        if args.camera is None:
            found = list_cameras()
            for one in found:
                if one.fault is not None:
                    print(f"  {one}")
            picked = questions.choose(
                "Which camera and mode?",
                [one for one in found if one.fault is None],
                "an address such as http://HOST:8080/?action=stream",
            )
            args.camera = picked if isinstance(picked, str) else _short_exposed(picked)
        if "exposure=" not in args.camera and args.exposure is None:
            text = questions.number(
                "What is its exposure, in seconds? Type 0 where it is not known.", "0", 0.0, 1.0
            )
            args.exposure = float(text) or None
        if _worked(_cameras.run, args):
            return
        args.camera = args.exposure = None


def _short_exposed(camera: FoundCamera) -> str:
    """The address of a camera of the list, with a short exposure."""
    exposure = questions.number(
        "Which exposure, in seconds? A quarter of the frame time or less keeps the picture sharp.",
        f"{0.2 / (camera.rate_hz or _USUAL_HZ):.4f}",
        1e-5,
        1.0,
    )
    return f"{camera.address}{'&' if '?' in camera.address else '?'}exposure={exposure}"


def _check(args: argparse.Namespace) -> None:
    """Until every line is in order."""
    from servosight.app.commands.bench import _check as check

    print("\n4. Check. Nothing moves.")
    while True:
        try:
            return check.run(args)
        except InputError as error:
            print(f"  {error}")
        questions.ask("Correct what is not in order, then press Enter to check again.")


def _limits(args: argparse.Namespace) -> None:
    print("\n3. Limits that no command exceeds, in degrees from the servo's own middle.")
    args.low = float(questions.number("Least angle?", "-45", -180.0, -1.0))
    args.high = float(questions.number("Largest angle?", "45", 1.0, 180.0))
    rate = questions.number(
        "Largest rate, in deg/s? Type 0 for none: jumps of the command are then allowed.",
        "0",
        0.0,
        1e5,
    )
    args.rate = float(rate) or None
    args.duration = float(
        questions.number(
            "How long shall the servo move, in seconds?",
            f"{EXPERIMENT_S:g}",
            SHORTEST_S,
            LONGEST_S,
        )
    )
    args.output = Path(questions.ask("Which folder shall the results go to?", _free(FOLDER)))


def _experiment(args: argparse.Namespace) -> None:
    """Zero, then the whole of it; only after the word."""
    from servosight.app.commands.bench import _auto, _zero
    from servosight.models.base import make_folder

    folder = Path(args.output)
    print(
        f"\n5. Now the servo moves between {args.low:g} and {args.high:g} deg, at first slowly. "
        "Clear its way, and keep the supply's switch in reach."
    )
    word = questions.ask(f"Type {ARM} to let it move; anything else ends here.", "no")
    if word.lower() != ARM:
        print(f"Nothing moved. Later, without questions: {_again(args)}")
        return
    args.arm = True
    args.output = folder / "zero"
    args.action = "zero"
    make_folder(folder)
    zero = _moved(lambda: _zero.found(args))
    if not questions.agree("Is that how it is mounted, and shall the experiment begin?"):
        raise questions.Ended
    args.output, args.action = folder, "auto"
    print("\n6. The experiment: run, track, diagnose.")
    _moved(lambda: _auto.experiment(args, zero))
    print(f"The same again, without questions: {_again(args)}")


def _worked(action: Callable[[argparse.Namespace], None], args: argparse.Namespace) -> bool:
    """Do one of the bench's actions; False where it is to be tried again with other answers."""
    try:
        action(args)
    except InputError as error:
        _complain(error)
        return False
    return True


def _moved(action: Callable[[], questions.T]) -> questions.T:
    """What an action that moves the servo has found, tried again as often as it is wanted."""
    while True:
        try:
            return action()
        except InputError as error:
            _complain(error)
            print("The servo moves again.")


def _complain(error: InputError) -> None:
    """Say what did not work; Ended unless it is to be tried again."""
    print(f"  {error}")
    if not questions.agree("That did not work; try again?"):
        raise questions.Ended


def _free(name: str) -> str:
    """A name that no folder has yet."""
    count = 1
    while Path(name if count == 1 else f"{name}-{count}").exists():
        count += 1
    return name if count == 1 else f"{name}-{count}"


def _again(args: argparse.Namespace) -> str:
    """The command that does the same, with every option that was given or asked for."""
    words = ["servosight", "bench", "auto", "-o", f"{args.output}-again", "--arm"]
    words += [f"--{name}" for name in ("yes", "force") if getattr(args, name)]
    for name in ("servo", "camera", "stamp", *_NUMBERS):
        value = getattr(args, name)
        if value is not None:
            # Joined to its option, so that a number below zero is not taken for one.
            words.append(f"--{name}={value:.12g}" if name in _NUMBERS else f"--{name}={value}")
    return shlex.join(words)
