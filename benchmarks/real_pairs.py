"""The same answer twice: two runs of one servo, each diagnosed alone.

    python benchmarks/real_pairs.py                        every run that is missing, then the page
    python benchmarks/real_pairs.py --only xl330-400       runs whose name begins so, then the page

Reads the logs in the folder that SERVOSIGHT_DATA names; results gather in out/real-pairs/, and the
page docs/measured/real_pairs.md is drawn from all of them.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from real_servos.logs import RunResult, log
from real_servos.pairs import page
from servosight.diagnose import diagnose
from servosight.models.core import Estimate, write_text
from threads import AS_COMMAND, restart_unless

ROOT = Path(__file__).resolve().parent.parent
RESULTS = ROOT / "out" / "real-pairs"
PAGE = ROOT / "docs" / "measured" / "real_pairs.md"
SERVOS = {"sts3250-32": ("sts3250", 32), "xl330-200": ("xl330", 200), "xl330-400": ("xl330", 400)}
TRAJECTORIES = ("sin_sin", "up_and_down")


def alone(servo: str, trajectory: str, gain: int) -> RunResult:
    """What a diagnosis of one log by itself names, and with which parameters."""
    found = diagnose([log(servo, trajectory, gain)], auto=True)
    last = found.ladder[-1]
    return {
        "named": found.effects,
        "equivalents": found.equivalents,
        "one_of": dict(found.one_of),
        "stability": dict(found.stability),
        "verdict": found.verdict.value,
        "over_floor": last.held_out_rmse_deg / found.floor_deg,
        "parameters": {
            name: [one.value, one.sigma]
            for name, one in last.parameters.items()
            if isinstance(one, Estimate) and name != "bias"
        },
        "shown_from": {
            one.effect: [f"{one.effect}.{one.parameter}", one.value, one.below]
            for one in found.detectable
        },
    }


def main() -> None:
    """Run what is asked for, keep each result, draw the page."""
    parser = argparse.ArgumentParser(description="Two runs of one servo, each by itself.")
    parser.add_argument("--only", default="", help="names of runs that begin so")
    wanted = parser.parse_args().only
    RESULTS.mkdir(parents=True, exist_ok=True)
    for name, (servo, gain) in SERVOS.items():
        for trajectory in TRAJECTORIES:
            path = RESULTS / f"{name}-{trajectory}.json"
            if path.stem.startswith(wanted) and (wanted or not path.exists()):
                write_text(path, json.dumps(alone(servo, trajectory, gain), indent=1))
                print(path.stem, flush=True)
    results = {path.stem: json.loads(path.read_text()) for path in RESULTS.glob("*.json")}
    write_text(PAGE, page(results, list(SERVOS), TRAJECTORIES))


if __name__ == "__main__":
    restart_unless(AS_COMMAND)
    main()
