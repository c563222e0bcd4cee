"""BAM's servos as truth: run trials, keep their lines, say what was named; or draw the page.

    python benchmarks/bam_truth --python VENV/bin/python --trials 16
    python benchmarks/bam_truth --page

VENV is an environment of its own: `pip install numpy scipy colorama`, then
`pip install --no-deps --ignore-requires-python better-actuator-models==1.0.2`.
"""

import argparse
import json
import sys
from pathlib import Path

sys.path[0] = str(Path(__file__).resolve().parents[1])  # this folder is the package ``bam_truth``

from bam_truth.page import page
from bam_truth.trial import run_bam
from servosight.models.core import write_text

ROOT = Path(__file__).resolve().parents[2]


def main() -> None:
    """Run the seeds that the results lack."""
    parser = argparse.ArgumentParser(description="Diagnose servos of BAM's simulator.")
    parser.add_argument("--python", type=Path, help="an interpreter that has BAM")
    parser.add_argument("--trials", type=int, default=32)
    parser.add_argument("--seed", type=int, default=0, help="the first trial's seed")
    parser.add_argument("--results", type=Path, default=ROOT / "out" / "bam.jsonl")
    parser.add_argument("--page", action="store_true", help="only draw what stands in the results")
    args = parser.parse_args()
    lines = []
    if args.results.is_file():
        lines = [json.loads(line) for line in args.results.read_text().splitlines()]
    if args.page:
        write_text(ROOT / "docs" / "measured" / "bam.md", page(lines))
        return
    if args.python is None:
        parser.error("expected --python, an interpreter of an environment that has BAM")
    args.results.parent.mkdir(parents=True, exist_ok=True)
    done = {line["seed"] for line in lines}
    for seed in range(args.seed, args.seed + args.trials):
        if seed in done:
            continue
        line = run_bam(seed, args.python)
        with args.results.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(line, allow_nan=False) + "\n")
        print(f"{line['name']}: {' + '.join(line['named']) or 'nothing'} ({line['verdict']})")


if __name__ == "__main__":
    main()
