"""Run a scenario in many variations: identify, diagnose, score; continues an interrupted run."""

from __future__ import annotations

import argparse
import shlex
import sys
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from servosight.app.arguments import any_path
from servosight.app.terminal import console, next_command, progress, quiet
from servosight.models.base import InputError, StageProgress

if TYPE_CHECKING:
    from servosight.scenarios.sweeps import Tally

LINE_S = 30.0
"""Where standard error is no terminal, a line says so often how far the sweep is."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight sweep``."""
    parser.add_argument(
        "sweep",
        metavar="SWEEP.toml",
        help="a sweep file, or the name of a ready one, such as noise_by_frame_rate",
    )
    parser.add_argument(
        "-o", "--output", metavar="DIR", type=any_path, required=True, help="folder for the rows"
    )
    parser.add_argument(
        "--workers",
        metavar="N",
        type=_count,
        help="processes on this machine (default: one for each core; 0: none but this one)",
    )
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help="run on the workers of a Dask scheduler: its address or its scheduler file",
    )
    parser.add_argument(
        "--retry", action="store_true", help="run the cells that have failed before once more"
    )


def run(args: argparse.Namespace) -> None:
    """Run the cells that are missing; say how far it is, and how to go on after Ctrl-C."""
    from servosight.scenarios.sweeps import READY, read_sweep, run_sweep

    if args.scheduler is not None and args.workers is not None:
        raise InputError(
            "--workers: the workers are those of --scheduler, expected one of the two; leave one "
            "out"
        )
    sweep = read_sweep(args.sweep)
    out = console(args)
    again = shlex.join(_again(args))
    with progress(sweep.name) as show:
        tell = _Teller(show, sweep.size, again)
        try:
            tally = run_sweep(
                sweep,
                args.output,
                workers=args.workers,
                scheduler=args.scheduler,
                retry=args.retry,
                on_start=lambda engine: _dashboard(out.print, engine),
                on_progress=tell,
                on_interrupt=tell.interrupted,
            )
        except KeyboardInterrupt:
            tell.interrupted()
            raise
    out.print(
        f"{args.output}: {sweep.size} cells, {tally.earlier} of them there before, {tally.done} "
        f"run now, {tally.failed} failed"
    )
    for kind, count in tally.kinds.most_common(5):
        out.print(f"  {count} failed: {kind}")
    if tally.failed:
        out.print(f"To run failed cells again: {again} --retry")
    if args.sweep in READY and sweep.about:
        out.print(sweep.about)
    out.print(next_command("results", args.output, "--plot", "sweep.html"))


def _again(args: argparse.Namespace) -> list[str]:
    """The words of the command that goes on, on the same workers."""
    words = ["servosight", "sweep", args.sweep, "-o", str(args.output)]
    if args.scheduler is not None:
        words += ["--scheduler", args.scheduler]
    elif args.workers is not None:
        words += ["--workers", str(args.workers)]
    return words


class _Teller:
    """Shows progress on a terminal, or in a line now and then; says what fails again and again."""

    def __init__(self, show: StageProgress, total: int, again: str) -> None:
        self.show, self.total, self.again = show, total, again
        self.last = time.monotonic()
        self.tally: Tally | None = None
        self.ended = False

    def __call__(self, tally: Tally, said: Sequence[str]) -> None:
        """How far it is."""
        self.tally = tally
        self.show(tally.words(), tally.earlier + tally.done, tally.total)
        if quiet():
            return
        for sentence in said:
            print(f"note: {sentence}", file=sys.stderr, flush=True)
        if not sys.stderr.isatty() and time.monotonic() - self.last > LINE_S:
            self.last = time.monotonic()
            print(f"{self.words()}, {tally.words()}", file=sys.stderr, flush=True)

    def interrupted(self) -> None:
        """Say, once, how far it came and what goes on from there."""
        if not self.ended and not quiet():
            print(f"{self.words()}; to go on: {self.again}", file=sys.stderr, flush=True)
        self.ended = True

    def words(self) -> str:
        """How many cells are done."""
        if self.tally is None:
            return "no cell was done"
        return f"{self.tally.earlier + self.tally.done} of {self.total} cells are done"


def _dashboard(say: Callable[[str], Any], engine: Any) -> None:
    link = getattr(engine, "dashboard", "")
    if link:
        say(f"dashboard: {link} ({engine.workers} workers)")


def _count(text: str) -> int:
    if not text.isascii() or not text.isdigit() or int(text) > 10_000:
        raise argparse.ArgumentTypeError(f"{text!r} is no count, expected 0 to 10000 processes")
    return int(text)
