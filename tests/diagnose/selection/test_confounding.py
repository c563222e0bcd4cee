"""Which models recordings cannot distinguish, on tables of invented trials."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from servosight.diagnose.residuals import FIT, Judged
from servosight.diagnose.selection import (
    AcceptanceCriterion,
    Resolution,
    Score,
    Trial,
    alternatives,
    confounded,
)
from servosight.models.core import Recording

COUNT, NOISE_DEG = 800, 0.1
TIME_S = np.arange(COUNT) / 100.0
RECORDING = Recording("run", TIME_S, np.sin(TIME_S), TIME_S, np.sin(TIME_S))
RESOLUTION = Resolution(NOISE_DEG, AcceptanceCriterion(0.1, 0.0))
TIED_DEG = NOISE_DEG * (2.0 * 10.0 / COUNT) ** 0.5
"""Predictions apart by this much everywhere differ by 10 in log-likelihood."""


def trial(effects: str, off_deg: float, evidence: float = 0.0) -> Trial:
    """A model whose prediction is ``off_deg`` off; ``evidence`` is its gain on a model without."""
    names = tuple(effects.split())
    problem: Any = SimpleNamespace(effects=names, held={})
    uses = np.full(COUNT, FIT, dtype=np.int8)
    judged = Judged(RECORDING, RECORDING.angle_deg + off_deg, uses)
    found = Trial(names, SimpleNamespace(problem=problem), (judged,))  # type: ignore[arg-type]
    rms = 0.1 * float(np.exp(-evidence / COUNT))
    found.__dict__["score"] = Score(
        effects=names,
        parameters=0,
        samples=COUNT,
        mean_square_deg2=rms**2,
        train_rmse_deg=rms,
        validation_rmse_deg=rms,
        validation_samples=COUNT,
        gain_fitted=True,
    )
    return found


def unasked(one: Trial) -> Trial:
    raise AssertionError(f"{one.effects} was fitted again")


def names(trials: Any) -> list[str]:
    return [" ".join(one.effects) for one in trials]


def test_what_taking_one_for_the_other_costs() -> None:
    one, other = trial("a", 0.0), trial("b", 0.05)
    assert RESOLUTION.cost(one, other) == pytest.approx(COUNT * 0.05**2 / (2.0 * NOISE_DEG**2))
    assert RESOLUTION.cost(one, one) == 0.0
    exact = Resolution(0.0, RESOLUTION.criterion)
    assert exact.cost(one, one) == 0.0
    assert exact.cost(one, other) > 1e20


def test_alternatives_predict_the_same_with_no_more_effects_nearest_first() -> None:
    chosen = trial("a", 0.0, 200.0)
    tried = [
        chosen,
        trial("b", 0.9 * TIED_DEG, 100.0),
        trial("c", 0.3 * TIED_DEG, 100.0),
        trial("d", 1.1 * TIED_DEG, 100.0),
        trial("a e", 0.0, 200.0),
        trial("", -0.5 * TIED_DEG, 100.0),
    ]
    assert names(alternatives(chosen, tried, RESOLUTION, unasked)) == ["c", "", "b"]


@pytest.mark.parametrize(
    ("evidence", "again", "alike"),
    [(160.0, 0.5, True), (160.0, 1.5, False), (140.0, 0.5, False), (260.0, 0.5, False)],
)
def test_close_rivals_are_compared_on_all_samples(
    evidence: float, again: float, alike: bool
) -> None:
    """Apart by more than the noise now, and by ``again`` times that when fitted to all samples.

    They are not fitted again where the evidence parts them by 50 or more.
    """
    chosen, rival = trial("a", 0.0, 200.0), trial("b", 2.0 * TIED_DEG, evidence)
    later = {"a": trial("a", 0.0), "b": trial("b", again * TIED_DEG)}
    asked: list[str] = []

    def whole(one: Trial) -> Trial:
        asked.extend(one.effects)
        return later[one.effects[0]]

    found = alternatives(chosen, [rival], RESOLUTION, whole)
    assert names(found) == (["b"] if alike else [])
    assert asked == (["a", "b"] if abs(evidence - 200.0) < 50.0 else [])


def test_single_candidates_that_predict_the_same_name_one_another() -> None:
    """Those that gain less than 10 on the model without them are compared with none."""
    base = trial("z", 1.0)
    singles = [
        trial("z a", 0.0, 300.0),
        trial("z b", 0.4 * TIED_DEG, 300.0),
        trial("b2 z", 1.3 * TIED_DEG, 200.0),
        trial("z c", 5.0 * TIED_DEG, 200.0),
        trial("z idle", 0.0, 9.0),
    ]
    found = confounded(singles, base, RESOLUTION, unasked)
    assert found == {"a": ("b",), "b": ("a", "b2"), "b2": ("b",), "c": (), "idle": ()}
    assert confounded([], base, RESOLUTION, unasked) == {}


def test_only_what_may_be_the_answer_is_fitted_to_all_samples() -> None:
    """Within 50 of the best in evidence: two weak ones far behind are left as they are."""
    base, asked = trial("", 1.0), list[str]()
    singles = [
        trial("best", 0.0, 300.0),
        trial("near", 2.0 * TIED_DEG, 251.0),
        trial("weak", 9.0 * TIED_DEG, 120.0),
        trial("other", 12.0 * TIED_DEG, 110.0),
    ]

    def whole(one: Trial) -> Trial:
        asked.extend(one.effects)
        return trial(" ".join(one.effects), 0.0)

    groups = confounded(singles, base, RESOLUTION, whole)
    assert groups == {"best": ("near",), "near": ("best",), "weak": (), "other": ()}
    assert set(asked) == {"best", "near"}
