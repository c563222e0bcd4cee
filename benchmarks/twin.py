"""Skill on the twin: each effect hidden by MuJoCo's own physics, diagnosed without its truth.

Writes docs/measured/twin.md. Angles of a 120 Hz camera with 0.03 deg of noise, no video.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from servosight.diagnose.diagnose import Diagnosis, diagnose
from servosight.models.atomic import write_text
from servosight.models.registry import catalogue
from servosight.scenarios.draws import DRAWS, UNCATALOGUED_DRAWS
from servosight.scenarios.scenario import Scenario, hidden_effect, hidden_effects
from servosight.sim.run import angle_recording, run

PAGE = Path(__file__).parent.parent / "docs" / "measured" / "twin.md"
SEEDS = (11, 12, 13)


@dataclass(frozen=True)
class Score:
    """One diagnosis against its truth; errors of all parameters as (share of the truth, sigmas)."""

    named: tuple[str, ...]
    alike: tuple[str, ...]
    unexplained: bool
    before_deg: float
    over_floor: float
    errors: dict[str, tuple[float, float]]
    seconds: float


def score(scenario: Scenario) -> Score:
    """Simulate, diagnose, compare with the truth."""
    trajectory = run(scenario.servo.bench(), scenario.effects, scenario.excitation())
    recording = angle_recording(trajectory, scenario.camera, scenario.noise_deg, scenario.seed)
    result = diagnose([recording], catalogue=catalogue(), auto=True)
    return Score(
        result.effects,
        result.candidates[0].confounded_with if result.candidates else (),
        result.verdict == "unexplained",
        result.ladder[0].rung.trial.held_out_rmse_deg,
        result.ladder[-1].rung.trial.held_out_rmse_deg / result.floor_deg,
        errors(result, scenario.truth()),
        result.seconds,
    )


def errors(result: Diagnosis, truth: dict[str, float]) -> dict[str, tuple[float, float]]:
    """Of each parameter but the bias, whose truth is near zero."""
    found = {}
    for name, one in result.ladder[-1].parameters.items():
        if name in truth and name != "bias" and truth[name]:
            off = abs(one.value - truth[name])
            found[name] = off / abs(truth[name]), off / (one.sigma or np.inf)
    return found


def worst(scores: list[Score], names: list[str]) -> str:
    """The largest error among some parameters: share of the truth, and in sigmas."""
    known = [(*s.errors[n], n) for s in scores for n in names if n in s.errors]
    if not known:
        return "-"
    share, sigmas, name = max(known)
    return f"{100 * share:.2g} % ({name.rpartition('.')[2]}, {sigmas:.1f} sigma)"


def is_right(hidden: str, score: Score) -> bool:
    """Named exactly, or as one that the diagnosis says cannot be told from it.

    For an effect outside the catalogue, the verdict is unexplained.
    """
    if hidden in UNCATALOGUED_DRAWS:
        return score.unexplained
    if hidden in DRAWS:
        return score.named == (hidden,) or (len(score.named) == 1 and hidden in score.alike)
    return score.named == ()


def line(hidden: str, scores: list[Score]) -> str:
    """One row of the table."""
    right = [is_right(hidden, score) for score in scores]
    wrong = {
        " + ".join(s.named) or "nothing" for s, good in zip(scores, right, strict=True) if not good
    }
    own = [name for s in scores for name in s.errors if "." in name]
    cells = [
        hidden,
        f"{sum(right)} of {len(scores)}",
        ", ".join(sorted(wrong)) or "-",
        f"{min(s.before_deg for s in scores):.2g} to {max(s.before_deg for s in scores):.2g} deg",
        f"{max(s.over_floor for s in scores):.2f}",
        worst(scores, ["k", "T", "xi"]),
        worst(scores, own),
        f"{max(s.seconds for s in scores):.0f} s",
    ]
    print(" | ".join(cells), flush=True)
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    """All effects and none, each with every seed."""
    rows = [line("nothing", [score(hidden_effects([], seed)) for seed in SEEDS])]
    rows += [
        line(effect, [score(hidden_effect(effect, seed)) for seed in SEEDS])
        for effect in (*DRAWS, *UNCATALOGUED_DRAWS)
    ]
    head = (
        "hidden",
        "named right",
        "else named",
        "linear, held out",
        "final / floor, worst",
        "k, T, xi, worst",
        "its own parameters, worst",
        "longest",
    )
    table = "\n".join(["| " + " | ".join(head) + " |", "| --- " * len(head) + "|", *rows])
    write_text(
        PAGE,
        f"""# Hidden effects, named

Written by `benchmarks/twin.py` (part of `make benchmarks`): {len(SEEDS)} draws of servo and
strength for each effect (seeds {", ".join(map(str, SEEDS))}), 12 s at 120 Hz, 2 ms exposure, 0.03
deg of noise, two cores, no GPU. "Named right" means: this effect and no other, or one
that the diagnosis reports as confounded with it (as cogging and sensor_nonlinearity are, which have
one equation at one loop gain); for the last
{len(UNCATALOGUED_DRAWS)}, which no catalogue has, the verdict `unexplained`. The error of a
parameter is its share of the truth.

{table}
""",
    )


if __name__ == "__main__":
    main()
