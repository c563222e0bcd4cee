"""Find out which physical effects the linear model misses."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from servosight.app.arguments import (
    add_fixed,
    add_fmu,
    add_force,
    add_json,
    add_model_output,
    add_plugins,
    add_recordings,
    add_report,
    add_seed,
    any_path,
    fixed,
    fmu_names,
    identifiers,
    limit_pair,
    plugins_again,
    refuse_without,
    tolerance,
)
from servosight.app.completion import with_effects
from servosight.app.terminal import (
    check_outputs,
    console,
    made,
    next_command,
    progress,
    show_diagnosis,
    write_json,
)
from servosight.models.base import InputError, is_fmu

if TYPE_CHECKING:
    from rich.console import Console

    from servosight.diagnose import Diagnosis
    from servosight.models.core import Recording
    from servosight.models.effects import Effect
    from servosight.models.excitation import CommandLimits


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight diagnose``."""
    add_recordings(parser)
    parser.add_argument(
        "--validate",
        metavar="REC",
        type=any_path,
        action="append",
        default=[],
        help="validation recording: decides which effects are added (may be repeated; default: "
        "blocks of time)",
    )
    parser.add_argument(
        "--test",
        metavar="REC",
        type=any_path,
        action="append",
        default=[],
        help="test recording: its error is reported and decides nothing (may be repeated; "
        "default: blocks of time)",
    )
    parser.add_argument(
        "--auto",
        action="store_true",
        help="add the best effect, refit, repeat, until the error reaches the floor (noise and "
        "tolerance together)",
    )
    _add_known(parser)
    parser.add_argument(
        "--tolerance",
        metavar="DEG",
        type=tolerance,
        help="an error this small needs no further effect (default: 0.05 %% of the moved range)",
    )
    parser.add_argument(
        "--next",
        metavar="command.csv",
        type=any_path,
        dest="next_command",
        help="write a command that distinguishes the models that this recording cannot distinguish",
    )
    parser.add_argument(
        "--limits",
        metavar="DEG,DEG/S",
        type=limit_pair,
        help="largest angle and rate of that command (default: what the recordings have used)",
    )
    parser.add_argument(
        "--draft",
        metavar="EFFECT.py",
        type=any_path,
        help="write a law for the error that no effect explains, as a plugin file",
    )
    add_fmu(parser)
    add_seed(parser, words="has no effect: the selection is deterministic; accepted for scripts")
    add_model_output(parser)
    add_json(parser)
    add_report(parser)
    add_plugins(parser)
    add_force(parser)


def _add_known(parser: argparse.ArgumentParser) -> None:
    known = parser.add_argument_group("what you know already")
    known.add_argument(
        "--from",
        metavar="MODEL",
        type=any_path,
        dest="start",
        help="start from this model: a card's effects, and its values as the initial guess; or an "
        "FMU (MODEL.fmu) in the place of the linear model, with effects around it",
    )
    for word, name, meaning in (
        ("--with", "with_effects", "effects that every model has (may be repeated)"),
        ("--without", "without_effects", "effects that are never tried (may be repeated)"),
    ):
        with_effects(
            known.add_argument(
                word,
                metavar="ID,ID",
                dest=name,
                action="extend",
                type=identifiers,
                default=[],
                help=meaning,
            )
        )
    add_fixed(known)


def run(args: argparse.Namespace) -> None:
    """Diagnose, print, write the card, the JSON and the report."""
    from servosight.app.inputs import load
    from servosight.models.effects import catalogue

    check_outputs(args)
    foreign = is_fmu(args.start)
    if foreign and args.output is not None:
        raise InputError(
            f"{args.start}: -o writes a model card, which cannot hold an FMU, expected --json or "
            f"--report"
        )
    if not foreign:
        refuse_without("--from MODEL.fmu", fmu_names(args))
    effects = catalogue(args.plugin)
    # What contradicts itself is refused before recordings are read, some of which are videos.
    diagnose = _of_fmu(args) if foreign else _of_card(args, effects)
    runs = [load(paths, args) for paths in (args.recordings, args.validate, args.test)]
    with progress("diagnosing") as show:
        result = diagnose(
            *runs,
            catalogue=effects,
            auto=args.auto,
            tolerance=args.tolerance,
            limits=_limits(args, runs[0]),
            progress=show,
        )
    known = result.known_effects or effects
    _show(args, result, known, [one for group in runs for one in group])


def _of_card(args: argparse.Namespace, effects: Mapping[str, Effect]) -> Callable[..., Diagnosis]:
    """The diagnosis of the linear model, or of a card."""
    from servosight.diagnose import PriorKnowledge, diagnose
    from servosight.models.core import Actuator

    prior = PriorKnowledge.of(
        effects,
        start=None if args.start is None else Actuator.load(args.start, effects),
        with_effects=args.with_effects,
        without_effects=args.without_effects,
        fix=fixed(args),
    )
    return partial(diagnose, prior=prior)


def _of_fmu(args: argparse.Namespace) -> Callable[..., Diagnosis]:
    """The same of an FMU."""
    from servosight.app.inputs import fmu_interface
    from servosight.diagnose import diagnose_fmu

    return partial(
        diagnose_fmu,
        fmu_interface(args, args.start),
        trust=args.trust,
        with_effects=args.with_effects,
        without_effects=args.without_effects,
        fix=fixed(args),
    )


def _show(
    args: argparse.Namespace,
    result: Diagnosis,
    effects: Mapping[str, Effect],
    recordings: list[Recording],
) -> None:
    """What was found, on the terminal and in files."""
    if args.output is not None:
        result.actuator.save(args.output)
    values = result.to_dict()
    write_json(args.json, values)  # first, so that no error of a later output costs the search
    out = console(args)
    show_diagnosis(out, values)
    if args.next_command is not None:
        if result.proposal is None:
            out.print(f"{args.next_command}: not written, there are no two models to distinguish")
        elif not result.proposal.recommended:
            out.print(
                f"{args.next_command}: not written, no command within the limits distinguishes "
                "the models"
            )
        else:
            result.proposal.excitation.save(args.next_command)
            out.print(f"{args.next_command}: {result.proposal.command}")
    _draft(args, result, out)
    if args.report is not None:
        from servosight.app.report import write_report

        with progress("writing the report"):
            write_report(args.report, result, recordings, effects, **made(args))
        out.print(f"report: {args.report}")
    out.print(next_command(*_next(args, values)))


def _draft(args: argparse.Namespace, result: Diagnosis, out: Console) -> None:
    """Say what law was found; write it to the file that was asked for."""
    from servosight.models.base import write_text

    if result.law is not None:
        out.print(result.law.sentence)
        if args.draft is None:
            out.print("To read it as an effect and name it: add --draft EFFECT.py")
        else:
            write_text(args.draft, result.law.draft)
            out.print(f"{args.draft}: read it, name it, and add --plugin {args.draft}")
    elif args.draft is not None:
        why = (
            "no law was found for the remaining error"
            if args.auto
            else "only --auto searches for a law"
        )
        if args.auto and result.verdict != "unexplained":
            why = "no error remains to explain"
        out.print(f"{args.draft}: not written, {why}")


def _limits(args: argparse.Namespace, recordings: list[Recording]) -> CommandLimits | None:
    from dataclasses import replace

    from servosight.diagnose.experiment import recorded_limits

    if args.limits is None:
        return None
    angle, rate = args.limits
    return replace(recorded_limits(recordings), angle_deg=angle, rate_deg_s=rate)


def _next(args: argparse.Namespace, values: dict[str, Any]) -> list[object]:
    """The next command: select effects, view the report, save the model, try another run."""
    again: list[object] = ["diagnose", *args.recordings, "--auto"]
    again += [word for path in args.validate for word in ("--validate", path)]
    again += [word for path in args.test for word in ("--test", path)]
    again += plugins_again(args)
    again += [] if args.start is None else ["--from", args.start]
    again += ["--trust"] if args.trust else []
    again += [word for name in args.with_effects for word in ("--with", name)]
    again += [word for name in args.without_effects for word in ("--without", name)]
    again += [word for name, value in args.fix for word in ("--fix", f"{name}={value:g}")]
    if not args.auto and values["verdict"] != "no_effect_missing":
        return again
    if args.report is None:
        return [*again, "--report", "report.html"]
    if is_fmu(args.start):
        return _next_of_fmu(args, values)
    if args.output is None:
        return [*again, "-o", "model.toml"]
    return ["compare", args.output, "ANOTHER_REC"]


def _next_of_fmu(args: argparse.Namespace, values: dict[str, Any]) -> list[object]:
    """Fit the FMU's own parameters with the effects that were found, or try another run."""
    if not values["effects"]:
        return ["compare", args.start, "ANOTHER_REC", "--trust"]
    plugins = plugins_again(args)
    effects = ["--effects", ",".join(values["effects"])]
    return ["identify", *args.recordings, "--model", args.start, "--trust", *effects, *plugins]
