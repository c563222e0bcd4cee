"""Check, zero, run, track and diagnose; go on with experiments where they decide something."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from servosight.app.experiment import REPORT, check_written, write_found
from servosight.app.terminal import Shown, console, progress
from servosight.scenarios.durations import EXPERIMENT_S, check_duration

if TYPE_CHECKING:
    from rich.console import Console

    from servosight.scenarios.bench_experiment import Zero


def run(args: argparse.Namespace) -> None:
    """The whole experiment; asks before each further run, unless --yes is given."""
    experiment(args)


def experiment(args: argparse.Namespace, zero: Zero | None = None) -> None:
    """The whole experiment; ``zero`` where the slow run before it has been made and shown."""
    from servosight.app.commands.bench._check import show_lines
    from servosight.app.commands.bench._devices import check_armed, opened_camera, opened_servo
    from servosight.bench.session import check_camera, check_servo, check_surface, run_words
    from servosight.models.base import make_folder
    from servosight.models.core import InputError
    from servosight.scenarios.bench_experiment import carry_out

    duration_s = EXPERIMENT_S if args.duration is None else args.duration
    check_duration(duration_s)
    check_armed(args)
    out = console(args)
    make_folder(args.output)
    check_written(args.output, force=args.force)

    with opened_camera(args) as camera, opened_servo(args) as servo:
        lines = [*check_camera(camera), *check_servo(servo)]
        if all(line.good for line in lines):
            lines += check_surface(servo, camera)
        show_lines(out, lines)
        if not all(line.good for line in lines):
            raise InputError("bench auto: not everything is in order; the lines above say how")
        with progress("bench") as show:
            trial = carry_out(
                servo,
                camera,
                args.output,
                duration_s=duration_s,
                seed=args.seed,
                zero=zero,
                ask=lambda question: _agreed(question, out, show, yes=args.yes),
                progress=show,
                force=args.force,
            )
    if zero is None:
        for words in trial.zero.words:
            out.print(words)
    for one in trial.runs:
        for words in run_words(one):
            out.print(words)
    write_found(args.output, trial.diagnosis, list(trial.recordings), args, out)
    out.print(f"Open {args.output / REPORT} in a browser.")


def _agreed(question: str, out: Console, show: Shown, *, yes: bool) -> bool:
    """Ask leave for a further run; the progress shown makes room for it."""
    from servosight.app.commands.bench import _questions as questions

    with show.hidden():
        out.print(f"To learn more: {question}")
        if yes:
            return True
        try:
            return questions.agree("Run it now? The servo moves.", default=False)
        except questions.Ended:  # the user, or nobody there to ask
            return False
