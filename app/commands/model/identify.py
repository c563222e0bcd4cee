"""Fit the actuator's parameters to recordings."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from servosight.app.arguments import (
    add_fixed,
    add_fmu,
    add_force,
    add_json,
    add_model_output,
    add_plugins,
    add_recordings,
    add_seed,
    any_path,
    fixed,
    fmu_names,
    identifiers,
    plugins_again,
    refuse_with,
    refuse_without,
)
from servosight.app.completion import with_effects
from servosight.app.terminal import (
    check_outputs,
    console,
    next_command,
    progress,
    show_fit,
    show_identification,
    show_parameters,
    write_json,
)


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight identify``."""
    add_recordings(parser)
    with_effects(
        parser.add_argument(
            "--effects",
            metavar="ID,ID",
            type=identifiers,
            default=[],
            help="effects to fit with the linear core, or around an FMU; see servosight effects",
        )
    )
    parser.add_argument(
        "--method",
        help="combination (genetic algorithm and particle swarm, default), ga, pso or gradient",
    )
    parser.add_argument(
        "--model",
        metavar="MODEL.fmu",
        type=any_path,
        help="fit the parameters of this FMU instead",
    )
    parser.add_argument(
        "--parameters",
        metavar="NAME,NAME",
        type=identifiers,
        default=[],
        help="of an FMU: what to fit (default: all tunable parameters)",
    )
    add_fmu(parser)
    add_fixed(parser)
    add_seed(parser, default=None, words="seed of the random numbers (default: 0)")
    add_model_output(parser)
    add_json(parser)
    add_plugins(parser)
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Fit, print, write the card and the JSON."""
    from servosight.app.inputs import load
    from servosight.diagnose import with_detectable
    from servosight.identify.fit import check_method, identify, with_information
    from servosight.models.effects import catalogue, select

    check_outputs(args)
    if args.model is not None:
        _run_fmu(args)
        return
    refuse_without("--model MODEL.fmu", {"--parameters": args.parameters, **fmu_names(args)})
    method = args.method or "combination"
    check_method(method)
    effects = catalogue(args.plugin)
    chosen = select(effects, args.effects)
    recordings = load(args.recordings, args)
    with progress("fitting"):
        result = identify(
            recordings,
            chosen,
            catalogue=effects,
            method=method,
            seed=args.seed or 0,
            fix=fixed(args),
        )
    if args.output is not None:
        result.actuator.save(args.output)
    result = with_information(result, recordings, effects)
    result = with_detectable(result, recordings, effects)
    values = result.to_dict()
    out = console(args)
    show_identification(out, values)
    write_json(args.json, values)
    out.print(next_command("diagnose", *args.recordings, *_start(args, chosen), "--auto"))


def _start(args: argparse.Namespace, effects: Sequence[str]) -> list[object]:
    """The options by which a diagnosis starts from the effects that were fitted."""
    if not effects:
        return []
    if args.output is not None:
        return ["--from", args.output, *plugins_again(args)]
    named = [word for effect in effects for word in ("--with", effect)]
    return [*named, *plugins_again(args)]


def _run_fmu(args: argparse.Namespace) -> None:
    """The same for the parameters of an FMU."""
    from servosight.app.inputs import load
    from servosight.identify.foreign import identify_fmu
    from servosight.models.base import InputError
    from servosight.models.effects import catalogue

    # The search of an FMU's parameters is a local one, without random numbers.
    refuse_with("--model MODEL.fmu", {"--method": args.method, "--seed": args.seed})
    if args.output is not None:
        raise InputError(
            f"{args.model}: -o is for a model card, which cannot hold an FMU, expected none with "
            f"an FMU: --json has its parameters"
        )
    recordings = load(args.recordings, args)
    with progress("fitting"):
        result = identify_fmu(
            args.model,
            recordings,
            args.parameters,
            args.effects,
            catalogue=catalogue(args.plugin),
            trust=args.trust,
            fix=fixed(args),
            command=args.fmu_input,
            angle=args.fmu_output,
        )
    values = result.to_dict()
    out = console(args)
    show_parameters(out, values["parameters"])
    out.print(
        f"rmse {result.rmse_deg:.4g} deg over {result.samples} samples; noise "
        f"{result.noise_deg:.4g} deg, floor {result.floor_deg:.4g} deg"
    )
    show_fit(out, result.fit_percent)
    out.print(f"{result.method}, {result.seconds:.1f} s, stopped: {result.stopped}")
    for warning in result.warnings:
        out.print(f"note: {warning}")
    write_json(args.json, values)
