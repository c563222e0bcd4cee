"""How each threshold of the selection moves names, false alarms and error.

    python benchmarks/thresholds.py --facts out/hidden/results --trials 12

Trials of the hidden-effect benchmark whose facts a results file holds are diagnosed with the
thresholds of docs/search.md, then with one of them changed at a time. Each selection begins anew
and may cost as much as any other; what was simulated before is not simulated again. Prints a table,
which docs/selection.md reports.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

from hidden.draw import propose
from hidden.run import Results
from servosight.diagnose.residuals import held_out_rms
from servosight.diagnose.selection import (
    AcceptanceCriterion,
    ModelSelection,
    SelectionPolicy,
    Split,
    StepwiseSelector,
)
from servosight.identify.problem import TOLERANCE_SHARE, Work, joint_noise_deg
from servosight.models.core import Recording
from servosight.models.effects import catalogue

ROWS = ("single", "weak", "nothing", "pair")
MOST_BYTES = 2**30
"""Of simulated angles: those of one trial's selections."""
CHANGES: Mapping[str, tuple[float, ...]] = {
    "min_gain": (0.01, 0.15),
    "min_share": (0.1, 0.6),
    "min_removed": (0.3, 1.0),
    "min_evidence": (3.0, 30.0),
    "explained": (1.03, 1.3),
    "chance": (0.001, 0.1),
    "structure": (1.2, 2.5),
    "nested": (0.0, 10.0),
    "visible": (0.0, 1.0),
    "worse": (1.0, 1.2),
    "far": (1.5, 3.0),
    "most": (0.7, 0.98),
    "max_steps": (2, 10),
    "learnt": (0.0, 0.05),
    "effect_penalty": (0.03, 0.3),
    "rare_penalty": (0.1, 0.6),
    "parameter_penalty": (0.0, 0.03),
    "hopeless": (10.0, 60.0),
    "fewest": (100, 1000),
    "together": (4, 8),
    "core": (2, 4),
    "worth_going_on": (0.02, 0.15),
    "near": (1.0, 4.0),
    "unloaded": (1, 6),
}
"""Values on either side of each threshold of the policy.

Left out are ``tie``, ``undecided`` and ``closer``, which decide what is said beside a model and not
which model is selected, and ``ordinary``, which is a list of names.
"""


@dataclass(frozen=True)
class SelectionOutcome:
    """The result of the diagnosis of one trial."""

    right: bool
    false_alarm: bool
    over_floor: float


@dataclass(frozen=True)
class BenchmarkTrial:
    """A trial's recording, divided in two ways, what is hidden in it, and what was simulated."""

    row: str
    hidden: frozenset[str]
    floor_deg: float
    tolerance_deg: float
    splits: tuple[Split, Split]
    work: Work = field(default_factory=partial(Work, most_bytes=MOST_BYTES))

    @classmethod
    def of(cls, row: str, hidden: Sequence[str], recording: Recording) -> BenchmarkTrial:
        """A trial before any fit."""
        tolerance = TOLERANCE_SHARE * recording.moved_range_deg
        floor = math.hypot(joint_noise_deg((recording,)), tolerance)
        splits = Split.of((recording,)), Split.of((recording,), choice=1)
        return cls(row, frozenset(hidden), floor, tolerance, splits)

    def outcome(self, policy: SelectionPolicy) -> SelectionOutcome:
        """Select with ``policy``, as ``diagnose --auto`` does."""
        criterion = AcceptanceCriterion(self.floor_deg, self.tolerance_deg, policy)
        models = self._models(0)
        score = models.linear().score
        if criterion.settled(score) and not criterion.explained(score):
            models = self._models(1)
        last = StepwiseSelector(models, criterion).select().steps[-1].trial
        error = held_out_rms(models.tested(last))
        named = frozenset(last.effects)
        return SelectionOutcome(
            named == self.hidden, bool(named - self.hidden), error / self.floor_deg
        )

    def _models(self, choice: int) -> ModelSelection:
        """No fits, and no cost: only what was simulated before is not simulated again."""
        self.work.simulations, self.work.cost = 0, 0.0
        return ModelSelection(self.splits[choice], catalogue(), work=self.work)


def cases(facts: Path, rows: Sequence[str], trials: int) -> Iterator[BenchmarkTrial]:
    """The first trials of each row in a results file that these sources would draw again."""
    left = dict.fromkeys(rows, trials)
    for line in Results.at(facts).every():
        row, seed, known = line["row"], line["seed"], line["facts"]
        if not left.get(row):
            continue
        setup = propose(row, seed, known["attempt"])
        if list(setup.effects) != list(known["hidden"]):
            continue
        left[row] -= 1
        yield BenchmarkTrial.of(row, list(setup.effects), setup.record(known["noise_deg"]))


def described(outcomes: Sequence[SelectionOutcome]) -> str:
    """Named, false alarms, and rms of the test error over the floor."""
    count = len(outcomes)
    over = math.sqrt(sum(one.over_floor**2 for one in outcomes) / count)
    named = sum(one.right for one in outcomes)
    alarms = sum(one.false_alarm for one in outcomes)
    return f"{named} of {count} | {alarms} of {count} | {over:.3f}"


def main() -> None:
    """Print the table, a line for each change."""
    parser = argparse.ArgumentParser(description="Move each threshold of the selection.")
    parser.add_argument(
        "--facts", type=Path, required=True, help="the results folder of make hidden"
    )
    parser.add_argument("--rows", default=",".join(ROWS))
    parser.add_argument("--trials", type=int, default=12, help="trials a row")
    args = parser.parse_args()
    found = list(cases(args.facts, args.rows.split(","), args.trials))
    usual = SelectionPolicy()
    policies = {"as documented": usual} | {
        f"{name} = {value:g} (not {getattr(usual, name):.3g})": replace(usual, **{name: value})
        for name, values in CHANGES.items()
        for value in values
    }
    outcomes: dict[str, list[SelectionOutcome]] = {name: [] for name in policies}
    for place, case in enumerate(found):
        for name, policy in policies.items():
            outcomes[name].append(case.outcome(policy))
        print(f"<!-- {place + 1} of {len(found)} -->", flush=True)
    print("| thresholds | exactly what is hidden | something that is not | test error / floor |")
    print("| --- | --- | --- | --- |")
    for name, some in outcomes.items():
        print(f"| {name} | {described(some)} |")


if __name__ == "__main__":
    main()
