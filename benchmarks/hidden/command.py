"""The hidden-effect benchmark: ``make hidden``, or this with options for a part of it.

    python benchmarks/hidden --rows single,pair --trials 40 --seed 1000
    python benchmarks/hidden --rows single --only 1007

Results gather in out/hidden/results, the folder of a sweep, and a later run goes on from there.
What was diagnosed wrong is printed with its candidates and the seed that runs it alone. Page and
pictures are drawn by ``--page`` from all results that these sources made, half a run included.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from servosight.app.terminal import progress
from servosight.models.core import write_text

from .compound import score as compound
from .compound.trial import COMPOUND_ROWS
from .draw import ROWS, choice, choices
from .page import page
from .pictures import pictures
from .run import Line, Results, run_trials
from .score import explain, right

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "out" / "hidden" / "results"
DOCS = ROOT / "docs"
EVERY = (*ROWS, *COMPOUND_ROWS)


def main() -> None:
    """Run what is asked for and not there yet, say what went wrong; or draw the page."""
    args = _arguments()
    results = Results.at(args.results)
    if args.page:
        draw(results.lines())
    else:
        run(args, results)


def draw(lines: list[Line]) -> None:
    """Write the page and its pictures."""
    pictures([x for x in lines if x["row"] in ROWS], DOCS / "pictures" / "hidden")
    write_text(DOCS / "measured" / "hidden.md", page(lines, "make hidden"))


def run(args: argparse.Namespace, results: Results) -> None:
    """Run trials and print what they said."""
    rows = [row for row in args.rows.split(",") if row]
    jobs = [(row, seed) for row in rows for seed in _seeds(args, row)]
    with progress("hidden effects") as show:

        def on_line(line: Line, done: int, total: int) -> None:
            show(line["row"], done, total)
            if not _right(line):
                print(_explain(line), flush=True)

        lines = run_trials(results, jobs, args.processes, on_line)
    if args.only:
        print("\n".join(_explain(line) for line in lines))
    for row in rows:
        mine = [line for line in lines if line["row"] == row]
        print(f"{row}: {sum(map(_right, mine))} of {len(mine)} right")


def _right(line: Line) -> bool:
    return compound.exact(line) if line["row"] in COMPOUND_ROWS else right(line)


def _explain(line: Line) -> str:
    return compound.explain(line) if line["row"] in COMPOUND_ROWS else explain(line)


def _seeds(args: argparse.Namespace, row: str) -> list[int]:
    """Seeds to run: those asked for one by one, or the first that hide a wanted effect."""
    if args.only:
        return [int(seed) for seed in args.only.split(",")]
    if row in COMPOUND_ROWS:
        return list(range(args.seed, args.seed + args.trials))
    wanted = {name for name in args.effects.split(",") if name}
    seeds = range(args.seed, args.seed + args.trials * len(choices(row)))
    mine = [seed for seed in seeds if not wanted or wanted & set(choice(row, seed)[0])]
    return mine[: args.trials]


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Hide effects, diagnose, count.")
    parser.add_argument("--rows", default=",".join(EVERY), help=f"of {', '.join(EVERY)}")
    parser.add_argument("--effects", default="", help="only trials that hide one of these")
    parser.add_argument("--trials", type=int, default=300, help="trials a row")
    parser.add_argument("--seed", type=int, default=0, help="the first trial's seed")
    parser.add_argument("--only", default="", help="these seeds alone, and say all about them")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--results", type=Path, default=RESULTS)
    parser.add_argument("--page", action="store_true", help="only draw what stands in the results")
    return parser.parse_args()
