"""Design a command; report what a command or a recording can determine."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from servosight.app.arguments import (
    add_force,
    add_json,
    add_plugins,
    add_pulse,
    add_seed,
    any_path,
    identifiers,
    number,
    refuse_without,
)
from servosight.app.terminal import check_outputs, console, next_command, write_json
from servosight.models.base import Kind

if TYPE_CHECKING:
    from servosight.models.excitation import CommandLimits, Design, Form

SHAPES = {
    "steps": "random levels, each held (--dwell); shows limits and friction",
    "chirp": "sweep from --low to --high; shows the linear dynamics",
    "multisine": "odd random-phase multisine from --low to --high with detection lines, periodic",
    "prbs": "pseudo-random binary sequence, one bit each --dwell; much power at all frequencies",
    "triangle": "triangles at the full and a quarter of the angle (--frequency); play and friction",
    "sine": "one sine (--frequency); determines only gain and phase",
    "standard": "rest, steps, chirp, triangles at two amplitudes, multisine: for a first recording",
    "optimal": "the combination that best determines the parameters --for of --model",
}
"""The shapes with a line each; tests hold the names to those of models/excitation/_design.py."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight excite``."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = "shapes:\n" + "\n".join(f"  {name:10} {SHAPES[name]}" for name in SHAPES)
    what = parser.add_argument_group("what to do (one of the three)")
    what.add_argument("shape", metavar="SHAPE", nargs="?", help="write a command of this shape")
    what.add_argument(
        "--check",
        metavar="REC|command.csv",
        type=any_path,
        help="report whether this command determines the parameters of --model",
    )
    what.add_argument(
        "--analyse",
        metavar="REC",
        type=any_path,
        help="even and odd distortion in the response to an odd multisine, without a model",
    )
    parser.add_argument(
        "-o", "--output", metavar="command.csv", type=any_path, help="file to write"
    )
    limits = parser.add_argument_group("limits")
    for name, unit, words, default in (
        ("angle", "DEG", "largest angle from the centre", 20.0),
        ("rate", "DEG/S", "largest rate (default: none, jumps are allowed)", None),
        ("duration", "S", "length", 20.0),
        ("centre", "DEG", "angle to move about", 0.0),
        ("row-rate", "HZ", "rows a second", 250.0),
    ):
        tail = "" if default is None else f" (default {default:g})"
        limits.add_argument(
            f"--{name}", metavar=unit, type=number, default=default, help=words + tail
        )
    form = parser.add_argument_group("form of the shape (each has its default)")
    form.add_argument("--frequency", metavar="HZ", type=number, help="of sine and triangle")
    form.add_argument("--low", metavar="HZ", type=number, help="of chirp and multisine")
    form.add_argument("--high", metavar="HZ", type=number, help="of chirp and multisine")
    form.add_argument("--dwell", metavar="S", type=number, help="of steps and prbs")
    aim = parser.add_argument_group("for optimal and --check")
    aim.add_argument("--model", metavar="MODEL.toml", type=any_path, help="model to design for")
    aim.add_argument(
        "--for",
        dest="wanted",
        metavar="T,xi,...",
        type=identifiers,
        help="of optimal: parameters to determine (default: all of the model's)",
    )
    aim.add_argument(
        "--frame-rate", metavar="HZ", type=number, default=120.0, help="of the camera (default 120)"
    )
    aim.add_argument(
        "--noise", metavar="DEG", type=number, default=0.03, help="of the angle (default 0.03)"
    )
    add_seed(parser)
    add_json(parser)
    add_pulse(parser)
    add_plugins(parser)
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Design and write a command, check one, or analyse a recording."""
    from servosight.models.base import InputError

    if args.shape != "optimal":
        refuse_without("the shape optimal", {"--for": args.wanted})
        if args.check is None:
            refuse_without("the shape optimal or --check", {"--model": args.model})
    asked = [args.shape is not None, args.check is not None, args.analyse is not None]
    if sum(asked) != 1:
        raise InputError(
            f"excite: {sum(asked) or 'none'} of a shape, --check and --analyse given, expected one "
            f"of them; name a shape ({', '.join(SHAPES)}), --check FILE or --analyse REC alone"
        )
    check_outputs(args, Kind.TABLE)
    if args.check is not None:
        _check(args)
    elif args.analyse is not None:
        _analyse(args)
    else:
        _write(args)


def _write(args: argparse.Namespace) -> None:
    from servosight.models.base import InputError

    if args.output is None:
        raise InputError("excite: no file to write, expected -o command.csv; name one")
    limits, out = _limits(args), console(args)
    values: dict[str, Any] = {"schema": 1, "shape": args.shape}
    if args.shape == "optimal":
        made, found = _optimal(args, limits)
        values["information"] = found
    else:
        from servosight.models.excitation import design

        made = design(args.shape, limits, _form(args), args.seed)
    made.excitation.save(args.output)
    rows = made.excitation
    values |= {
        "command": made.words,
        "notes": list(made.notes),
        "rows": int(rows.time_s.size),
        "duration_s": rows.duration_s,
        "largest_deg": float(abs(rows.command_deg - limits.centre_deg).max()),
    }
    out.print(f"{args.output}: {made.words}; {rows.time_s.size} rows, {rows.duration_s:.4g} s")
    for note in made.notes:
        out.print(f"note: {note}")
    if "information" in values:
        out.print(values["information"]["sentence"])
    write_json(args.json, values)


def _optimal(args: argparse.Namespace, limits: CommandLimits) -> tuple[Design, dict[str, Any]]:
    from servosight.identify.design import optimal
    from servosight.models.core import Actuator
    from servosight.models.effects import catalogue

    effects = catalogue(args.plugin)
    actuator = Actuator.load(_model(args), effects)
    every = [name for name in actuator.parameters if name != "bias" and actuator.value(name) != 0.0]
    found = optimal(
        actuator,
        every if args.wanted is None else args.wanted,
        limits,
        catalogue=effects,
        frame_rate_hz=_positive(args.frame_rate, "--frame-rate"),
        noise_deg=_positive(args.noise, "--noise"),
        seed=args.seed,
    )
    return found.design, found.information.to_dict()


def _check(args: argparse.Namespace) -> None:
    from servosight.app.inputs import load
    from servosight.identify.design import assess, better_command, predicted_experiment
    from servosight.identify.problem import noise_deg
    from servosight.models.core import Actuator
    from servosight.models.effects import catalogue
    from servosight.models.excitation import Excitation
    from servosight.sources import is_command

    effects = catalogue(args.plugin)
    actuator = Actuator.load(_model(args), effects)
    if is_command(args.check):
        rows = Excitation.load(args.check)
        recording = predicted_experiment(rows, _positive(args.frame_rate, "--frame-rate"))
        noise = _positive(args.noise, "--noise")
    else:
        recording = load([args.check], args)[0]  # a horn's view comes behind its surface's
        noise = noise_deg(recording)
    found = assess(actuator, [recording], noise, catalogue=effects)
    values = {"schema": 1, **found.to_dict()}
    out = console(args)
    out.print(found.sentence)
    if not found.sufficient:
        better = better_command(actuator, recording, noise, catalogue=effects)
        if better is not None:
            values["better"] = better.sentence(found)
            out.print(values["better"])
    write_json(args.json, values)


def _analyse(args: argparse.Namespace) -> None:
    from servosight.app.inputs import load
    from servosight.identify.discrete import distortion
    from servosight.models.base import InputError

    recording = load([args.analyse], args)[0]  # a horn's view comes behind its surface's
    found = distortion(recording)
    if found is None:
        raise InputError(
            f"{args.analyse}: the command is no periodic odd multisine, expected one with odd "
            f"lines left out; write one with `servosight excite multisine -o command.csv`"
        )
    out = console(args)
    out.print(
        f"{found.periods} settled periods of {found.period_s:.4g} s; {found.response.lines} lines "
        f"excited, {found.odd.lines} odd and {found.even.lines} even ones to detect distortion"
    )
    out.print(found.sentence)
    write_json(args.json, {"schema": 1, **found.to_json()})
    if found.odd.found or found.even.found:
        out.print(next_command("diagnose", args.analyse, "--auto"))


def _limits(args: argparse.Namespace) -> CommandLimits:
    from servosight.models.excitation import CommandLimits

    return CommandLimits(args.angle, args.rate, args.duration, args.centre, args.row_rate)


def _form(args: argparse.Namespace) -> Form:
    from servosight.models.excitation import Form

    return Form(args.frequency, args.low, args.high, args.dwell)


def _model(args: argparse.Namespace) -> Path:
    from servosight.models.base import InputError

    if args.model is None:
        raise InputError(
            "excite: no model, expected --model MODEL.toml as `servosight identify -o MODEL.toml` "
            "writes it; name one"
        )
    return Path(args.model)


def _positive(value: float, option: str) -> float:
    from servosight.models.base import InputError

    if value <= 0.0:
        raise InputError(f"{option} {value:g}: expected more than 0; give a larger one")
    return value
