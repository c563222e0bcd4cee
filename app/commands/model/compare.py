"""Show where a model fails on recordings, or what differs between two models or recordings."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from servosight.app.arguments import (
    add_fixed,
    add_fmu,
    add_force,
    add_json,
    add_plugins,
    add_recordings,
    add_report,
    any_path,
    fixed,
    fmu_names,
    identifiers,
    plugins_again,
    refuse_without,
)
from servosight.app.completion import with_effects
from servosight.app.terminal import (
    check_outputs,
    console,
    made,
    next_command,
    progress,
    show_change,
    show_findings,
    show_fit,
    show_where,
    write_json,
)
from servosight.models.base import is_fmu, is_model_file

if TYPE_CHECKING:
    from servosight.models.effects import Effect


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight compare``."""
    parser.add_argument(
        "model",
        metavar="MODEL.toml",
        type=any_path,
        help="the model's card, or an FMU; or the first of two cards, or of two recordings",
    )
    add_recordings(parser)
    with_effects(
        parser.add_argument(
            "--effects",
            metavar="ID,ID",
            type=identifiers,
            help="of two recordings: the effects to fit to both (default: found by a diagnosis)",
        )
    )
    add_fixed(parser)
    add_fmu(parser)
    add_json(parser)
    add_report(parser)
    add_plugins(parser)
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Simulate, compare, print, write the JSON and the report."""
    from servosight.app.inputs import fmu_interface, load
    from servosight.diagnose import compare, compare_fmu
    from servosight.diagnose.change import refuse_fitting
    from servosight.models.core import Actuator
    from servosight.models.effects import catalogue

    check_outputs(args)
    args.model, *args.recordings = _model_first([args.model, *args.recordings])
    if not is_fmu(args.model):
        refuse_without("an FMU as the model", fmu_names(args))
    if not is_model_file(args.model) or is_model_file(args.recordings[0]):
        _change(args)
        return
    refuse_fitting(args.effects, fixed(args))
    effects: Mapping[str, Effect] = catalogue(args.plugin)
    start: list[object] = []
    if is_fmu(args.model):
        start = ["--from", args.model, "--trust"]
        recordings = load(args.recordings, args)
        with progress("comparing"):
            result = compare_fmu(fmu_interface(args, args.model), recordings, trust=args.trust)
        effects = result.known_effects or effects
    else:
        actuator = Actuator.load(args.model, effects)
        if actuator.effects:
            start = ["--from", args.model, *plugins_again(args)]
        recordings = load(args.recordings, args)
        with progress("comparing"):
            result = compare(actuator, recordings, catalogue=effects)
    values = result.to_dict()
    out = console(args)
    out.print(f"{result.headline}. {result.summary}")
    show_fit(out, result.fit_percent)
    show_findings(out, values["findings"], values["sentences"][0])
    if not result.explained:
        show_where(out, values["where"], "where the model fails")
    for warning in values["warnings"]:
        out.print(f"note: {warning}")
    if args.report is not None:
        from servosight.app.report import write_report

        with progress("writing the report"):
            write_report(args.report, result, recordings, effects, **made(args))
        out.print(f"report: {args.report}")
    write_json(args.json, values)
    if result.explained:
        out.print(next_command("compare", args.model, "ANOTHER_REC"))
    else:
        out.print(next_command("diagnose", *args.recordings, *start, "--auto"))


def _model_first(given: list[Path]) -> list[Path]:
    """The one model in front of the recordings, wherever it was named; else as they were given."""
    models = [path for path in given if is_model_file(path)]
    if len(models) != 1:
        return given
    return [*models, *(path for path in given if path is not models[0])]


def _change(args: argparse.Namespace) -> None:
    """Two models, or two recordings: fit, compare, print, write the JSON and the report."""
    import servosight
    from servosight.models.core import InputError

    if len(args.recordings) != 1:
        raise InputError(
            f"compare: {len(args.recordings) + 1} to compare with one another, expected two; put "
            f"the recordings of each side into a folder"
        )
    with progress("comparing") as show:
        result = servosight.compare(
            args.model,
            args.recordings[0],
            effects=args.effects,
            fix=fixed(args),
            plugins=args.plugin,
            progress=show,
        )
    values = result.to_dict()
    out = console(args)
    show_change(out, values)
    if args.report is not None:
        from servosight.app.report import write_report
        from servosight.models.effects import catalogue

        with progress("writing the report"):
            write_report(args.report, result, catalogue=catalogue(args.plugin), **made(args))
        out.print(f"report: {args.report}")
    write_json(args.json, values)
