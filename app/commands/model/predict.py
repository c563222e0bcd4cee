"""Run a model on a command, or on the command of a recording."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from servosight.app.arguments import (
    add_fmu,
    add_force,
    add_plugins,
    add_pulse,
    any_path,
    fmu_names,
    number,
    refuse_without,
)
from servosight.app.terminal import check_outputs, console
from servosight.models.base import Kind, is_fmu

if TYPE_CHECKING:
    from collections.abc import Callable

    from servosight.models.core import Array, Recording


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight predict``."""
    parser.add_argument("model", metavar="MODEL", type=any_path, help="the model's card, or an FMU")
    parser.add_argument(
        "command_file",
        metavar="COMMAND.csv|REC",
        type=any_path,
        help="time_s,command_deg, each held until the next; or a recording",
    )
    parser.add_argument(
        "-o", "--output", metavar="angle.csv", type=any_path, required=True, help="file to write"
    )
    parser.add_argument(
        "--rate",
        metavar="HZ",
        type=number,
        help="of a command: angles a second, from its first row to its last (default: at its rows "
        "where these are at most 10 ms apart, else 100)",
    )
    add_pulse(parser)
    add_fmu(parser)
    add_plugins(parser)
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Simulate and write ``time_s,angle_deg,command_deg``; of a recording, print the error too."""
    from servosight.app.inputs import load
    from servosight.models.base import write_text
    from servosight.models.core import rms
    from servosight.models.io import table_text
    from servosight.sources import to_predict

    check_outputs(args, Kind.TABLE)
    out = console(args)
    predicted = _predictor(args)
    recording, from_rest = to_predict(
        args.command_file, args.rate, lambda _: load([args.command_file], args)[0]
    )
    angle = predicted(recording, from_rest)
    words = "from rest"
    if not from_rest:
        error_deg = rms(angle - recording.angle_deg)
        words = f"rms difference from the measured angle {error_deg:.3g} deg"
    time_s = recording.time_s
    columns = (time_s, angle, recording.command_at(time_s))
    write_text(args.output, table_text(("time_s", "angle_deg", "command_deg"), columns))
    out.print(
        f"{args.output}: {time_s.size} samples, {angle.min():.4g} to {angle.max():.4g} deg, {words}"
    )


def _predictor(args: argparse.Namespace) -> Callable[[Recording, bool], Array]:
    """What the card or the FMU predicts of a recording: from its first samples, or from rest."""
    from servosight.app.inputs import fmu_interface
    from servosight.identify.foreign import predict_fmu
    from servosight.models.core import Actuator
    from servosight.models.effects import catalogue
    from servosight.models.plant import predict_from_rest, to_the_end

    if is_fmu(args.model):
        interface = fmu_interface(args, args.model)
        return lambda recording, from_rest: predict_fmu(
            interface, recording, from_rest=from_rest, trust=args.trust
        )
    refuse_without("an FMU as the model", fmu_names(args))
    effects = catalogue(args.plugin)
    actuator = Actuator.load(args.model, effects)

    def predicted(recording: Recording, from_rest: bool) -> Array:
        if from_rest:
            return to_the_end(predict_from_rest(actuator, recording, effects), recording)
        return actuator.predict(recording, catalogue=effects)

    return predicted
