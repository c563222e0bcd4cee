"""Arguments that several commands share, and the types that check them."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from pathlib import Path

from servosight.models.base import InputError, check_path, check_tolerance


def add_general(parser: argparse.ArgumentParser, default: object = False) -> None:
    """What stands before the command or behind it: --quiet, --verbose and --debug."""
    options = parser.add_mutually_exclusive_group()
    for names, words in (
        (("-q", "--quiet"), "print nothing but JSON and errors"),
        (("-v", "--verbose"), "report each stage and its duration on standard error"),
    ):
        options.add_argument(*names, action="store_true", default=default, help=words)
    parser.add_argument(
        "--debug", action="store_true", default=default, help="show the traceback of an error"
    )


def add_recordings(parser: argparse.ArgumentParser) -> None:
    """``REC...`` and the scale of a command given as pulse width."""
    parser.add_argument(
        "recordings",
        metavar="REC",
        nargs="+",
        type=any_path,
        help="recording: a folder, a CSV file, or a log that servosight import reads",
    )
    add_pulse(parser)


def add_pulse(parser: argparse.ArgumentParser) -> None:
    """``--deg-per-us`` and ``--neutral-us``."""
    pulse = parser.add_argument_group("a command given as pulse width (column command_us)")
    pulse.add_argument(
        "--deg-per-us", metavar="DEG", type=number, help="degrees for one microsecond"
    )
    pulse.add_argument("--neutral-us", metavar="US", type=number, help="pulse width at 0 deg")


def add_model_output(parser: argparse.ArgumentParser) -> None:
    """``-o MODEL.toml``."""
    parser.add_argument(
        "-o", "--output", metavar="MODEL.toml", type=any_path, help="write the fitted model's card"
    )


def add_json(parser: argparse.ArgumentParser) -> None:
    """``--json FILE``, ``-`` for standard output."""
    parser.add_argument(
        "--json",
        metavar="FILE",
        type=any_path,
        help="write the result as JSON; - for standard output",
    )


def add_report(parser: argparse.ArgumentParser) -> None:
    """``--report FILE.html``."""
    parser.add_argument(
        "--report", metavar="FILE.html", type=any_path, help="write a report to read in a browser"
    )


def add_plugins(parser: argparse.ArgumentParser) -> None:
    """``--plugin FILE.py``, repeatable."""
    parser.add_argument(
        "--plugin",
        metavar="FILE.py",
        type=any_path,
        action="append",
        default=[],
        help="a file with an effect of your own (it is run; may be repeated)",
    )


def plugins_again(args: argparse.Namespace) -> list[str]:
    """The options that name the same files once more, for a command that is proposed."""
    return [word for path in args.plugin for word in ("--plugin", path)]


def add_fmu(parser: argparse.ArgumentParser) -> None:
    """``--trust``, ``--fmu-input`` and ``--fmu-output``, for a model that is an FMU."""
    parser.add_argument(
        "--trust",
        action="store_true",
        help="of an FMU: run its native code, with your rights, in a process of its own",
    )
    for name, what in (("input", "command"), ("output", "angle")):
        parser.add_argument(
            f"--fmu-{name}",
            metavar="NAME",
            help=f"of an FMU: the variable of the {what} (default: {what}, or the only {name})",
        )


def refuse_without(needed: str, options: Mapping[str, object]) -> None:
    """Raise InputError for the first of ``options`` that has a value, where ``needed`` is missing.

    Ignored, such an option would let the user take the result for what it is not.
    """
    for option in _given(options):
        raise InputError(
            f"{option} has no effect here, expected {needed} beside it; add that, or leave "
            f"{option} out"
        )


def refuse_with(present: str, options: Mapping[str, object]) -> None:
    """Raise InputError for the first of ``options`` that has a value, which ``present`` ignores."""
    for option in _given(options):
        raise InputError(
            f"{option} has no effect with {present}, expected one of the two; leave the other out"
        )


def _given(options: Mapping[str, object]) -> list[str]:
    """Those of ``options`` that stand on the command line; their defaults are no value."""
    return [
        name
        for name, value in options.items()
        if value is not None and value is not False and value != []
    ]


def add_seed(
    parser: argparse.ArgumentParser,
    default: int | None = 0,
    words: str = "seed of the random numbers (default: %(default)s)",
) -> None:
    """``--seed N``."""
    parser.add_argument("--seed", metavar="N", type=whole, default=default, help=words)


def fmu_names(args: argparse.Namespace) -> dict[str, object]:
    """The options that name an FMU's variables, with their values."""
    return {"--fmu-input": args.fmu_input, "--fmu-output": args.fmu_output}


def add_fixed(parser: argparse._ActionsContainer) -> None:
    """``--fix NAME=VALUE``, repeatable."""
    parser.add_argument(
        "--fix",
        metavar="NAME=VALUE",
        type=assignment,
        action="append",
        default=[],
        help="hold a parameter: k, T, xi or EFFECT.PARAMETER (may be repeated)",
    )


def fixed(args: argparse.Namespace) -> dict[str, float]:
    """The parameters of ``--fix`` by name; InputError where one is given twice."""
    values: dict[str, float] = {}
    for name, value in args.fix:
        if name in values:
            raise InputError(
                f"--fix {name}: is given twice, with {values[name]:g} and {value:g}, expected each "
                f"parameter once; leave one of them out"
            )
        values[name] = value
    return values


def add_force(parser: argparse.ArgumentParser) -> None:
    """``--force``."""
    parser.add_argument(
        "--force", action="store_true", help="replace existing files that servosight did not write"
    )


def any_path(text: str) -> Path:
    """A path that a file or folder can have; an empty one would be the working directory."""
    if not text:
        raise argparse.ArgumentTypeError("is empty, expected the path of a file or folder")
    path = Path(text)
    try:
        check_path(path)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return path


def number(text: str) -> float:
    """A finite number."""
    value = _float(text)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"{text!r} is not finite, expected a number")
    return value


def whole(text: str) -> int:
    """A whole number from 0."""
    if not text.isascii() or not text.isdigit() or len(text) > 18:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number from 0")
    return int(text)


def rank(text: str) -> int:
    """A whole number from 1."""
    if not text.isascii() or not text.isdigit() or not 0 < int(text[:9]) <= 99 or len(text) > 2:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number from 1 to 99")
    return int(text)


def tolerance(text: str) -> float:
    """An error of an angle [deg] that no model need go below."""
    value = number(text)
    try:
        check_tolerance(value)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
    return value


def assignment(text: str) -> tuple[str, float]:
    """``NAME=VALUE``."""
    name, equals, value = text.partition("=")
    if not (equals and name.strip()):
        raise argparse.ArgumentTypeError(f"{text!r}: expected NAME=VALUE such as k=1")
    return name.strip(), number(value)


def identifiers(text: str) -> list[str]:
    """``a,b`` as a list of names."""
    return [word.strip() for word in text.split(",") if word.strip()]


def point(text: str) -> tuple[float, float]:
    """``X,Y``."""
    x, y = _numbers(text, 2, "X,Y such as 320,240")
    return x, y


def limit_pair(text: str) -> tuple[float, float]:
    """``DEG,DEG/S``, both above 0."""
    angle, rate = _numbers(text, 2, "DEG,DEG/S such as 30,300")
    if min(angle, rate) <= 0.0:
        raise argparse.ArgumentTypeError(f"{text!r}: expected two numbers above 0, such as 30,300")
    return angle, rate


def box(text: str) -> tuple[int, int, int, int]:
    """``X,Y,W,H``, in whole pixels."""
    x, y, width, height = (round(v) for v in _numbers(text, 4, "X,Y,W,H such as 300,200,120,60"))
    return x, y, width, height


def _numbers(text: str, count: int, shape: str) -> list[float]:
    words = text.split(",")
    if len(words) != count:
        raise argparse.ArgumentTypeError(f"{text!r}: expected {shape}")
    return [number(word) for word in words]


def _float(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no number, expected one") from None
