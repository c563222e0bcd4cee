"""Warnings of a diagnosis: what it took for granted, and where chance or its length decided."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from servosight.diagnose.evidence import Evidence
from servosight.diagnose.residuals import phrased
from servosight.diagnose.result._diagnosis import LadderStep, Verdict
from servosight.diagnose.result.wording import Levels
from servosight.models.core import rounded


def assumed(held: Mapping[str, float], fixed: Mapping[str, float]) -> list[str]:
    """A warning where the model holds parameters that are not ``fixed`` by the user.

    >>> assumed({"k": 1.0}, {})[0][:14], assumed({"k": 1.0}, {"k": 1.0})
    ('k is held at 1', [])
    """
    return [
        f"{name} is held at {value:g} and has no sigma, as a loop with its sensor on the output "
        f"reaches what it is asked for: with another {name} the model predicts the data no better "
        f"(--fix {name}=VALUE where you know it)"
        for name, value in held.items()
        if name not in fixed
    ]


def held_otherwise(
    before: Mapping[str, float], held: Mapping[str, float], values: Mapping[str, float]
) -> tuple[str, ...]:
    """What a step of the ladder holds that the step ``before`` fitted, to ``values``, or fits anew.

    >>> held_otherwise({}, {"k": 1.0}, {"k": 0.931, "T": 0.02})[0][:36]
    'k held at 1 from here, 0.931 before:'
    >>> held_otherwise({"k": 1.0}, {}, {"k": 1.0}), held_otherwise({}, {}, {"k": 1.0})
    (('k fitted from here, held at 1 before',), ())
    """
    return (
        *(
            f"{name} held at {value:g} from here, {rounded(values[name])} before: a loop with its "
            f"sensor on the output reaches what it is asked for but for load and friction, so the "
            f"error of this step may be larger on that account"
            for name, value in held.items()
            if name not in before
        ),
        *(
            f"{name} fitted from here, held at {value:g} before"
            for name, value in before.items()
            if name not in held
        ),
    )


def doubts(verdict: Verdict, last: LadderStep, levels: Levels) -> list[str]:
    """A warning where the test's error is above the limit, though no more than chance allows."""
    if verdict is Verdict.UNEXPLAINED or last.explained:
        return []
    error = levels.words(last.held_out_rmse_deg)
    if levels.scatter_deg > levels.noise_deg:
        return [
            f"the error on the test data is {error}, which chance allows, as the scatter between "
            f"few runs is not known well; repeat the command more often to be sure"
        ]
    return [
        f"the error on the few test samples is {error}, which chance allows; record longer to be "
        f"sure"
    ]


def unmoved(last: LadderStep) -> list[str]:
    """A warning where the test data do not move, and so test little."""
    if last.fit_percent is not None:
        return []
    return [
        "the test data move no more than the floor, so that their error says nothing about motion: "
        "test on a recording that moves (--test REC)"
    ]


def compensating(
    verdict: Verdict, effects: Sequence[str], known: Evidence, slight: bool
) -> list[str]:
    """A warning where fitted values of a model with ``effects`` stand for what it lacks.

    Empty where most of the error is beyond the fitted data, or where parameters within their sigma
    may be all of it: then nothing need be missing. Where the error is ``slight``, what is missing
    may be no effect, and the values are not far off.
    """
    lacking = known.leading is None and not known.by_chance
    if verdict is not Verdict.UNEXPLAINED or not effects or not lacking:
        return []
    model = f"the model with {phrased(effects)}"
    if slight:
        return [
            f"little is missing in {model}, whose error is near the floor: an effect too weak to "
            f"be accepted, or faults of the log, such as wrong values and late stamps; the fitted "
            f"values may be off by more than their sigma"
        ]
    lacked = "it lacks" if known.cut_short else "is not in the catalogue"
    return [
        f"the fitted values of {model} compensate for an effect that {lacked}; "
        f"they are not physical: do not use them"
    ]


def ended(verdict: Verdict, cut_short: bool, simulations: int) -> list[str]:
    """A warning where the search ended because of its length, not because all was tried."""
    if not cut_short:
        return []
    so_far = (
        "the model explains the data, and other sets of effects that do may be untried"
        if verdict is Verdict.EXPLAINED
        else "this is the best model found by then, and further sets are untried"
    )
    return [
        f"the search for effects was stopped at the limit of its cost, after {simulations:,} "
        f"simulations: {so_far}"
    ]
