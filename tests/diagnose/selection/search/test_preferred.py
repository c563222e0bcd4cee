"""Which of several models that err about as much is told: the one of fewest assumptions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from servosight.diagnose.residuals import Judged
from servosight.diagnose.selection import AcceptanceCriterion, ModelSelection, Split, Trial
from servosight.diagnose.selection.search import fewest_assumptions
from servosight.identify.fit import Solution
from servosight.models.core import Recording
from servosight.models.effects import catalogue

TIME_S = np.arange(200) / 50.0
RECORDING = Recording("log", TIME_S, 20.0 * np.sin(TIME_S), TIME_S, 20.0 * np.sin(TIME_S))
MODELS = ModelSelection(Split.of([RECORDING]), catalogue())
CRITERION = AcceptanceCriterion(0.05, 0.01)
HELD = {"k": 1.0}
FREE: dict[str, float] = {}


def trial(effects: str, held: dict[str, float], error_deg: float, unseen: float = 1.0) -> Trial:
    """A model with a given error, which is ``unseen`` times as large on the validation samples."""
    problem = MODELS.problem(effects.split(), held)
    point = np.clip(np.zeros(len(problem.coordinates)), *problem.bounds)
    uses = MODELS.split.uses[0]
    error = error_deg * np.where(uses == 0, 1.0, unseen) * np.where(np.arange(200) % 2, 1.0, -1.0)
    judged = (Judged(RECORDING, RECORDING.angle_deg - error, uses),)
    return Trial(problem.effects, Solution.at(problem, point), judged)


def told(tried: list[Trial], last: Trial, accepted: Callable[[Trial], bool] | None = None) -> Trial:
    """The model that is preferred, where fits to all samples err as the models themselves do."""
    accepts = accepted or (lambda one: True)
    return fewest_assumptions(tried, last, CRITERION, accepts, lambda one: one.score)


@pytest.mark.parametrize(
    ("error_deg", "effects"),
    [(0.41, "coulomb_friction gravity_load"), (0.50, "coulomb_friction")],
    ids=["as much", "more"],
)
def test_a_weight_is_told_before_another_k(error_deg: float, effects: str) -> None:
    last = trial("coulomb_friction", FREE, 0.40)
    other = trial("coulomb_friction gravity_load", HELD, error_deg)
    found = told([last, other], last)
    assert set(found.effects) == set(effects.split())


def test_an_effect_less_is_told_where_it_errs_about_as_much() -> None:
    last = trial("supply_sag stribeck_friction", FREE, 0.40)
    fewer = trial("load_dependent_friction gravity_load", HELD, 0.47)
    more = trial("supply_sag stribeck_friction dead_time backlash", HELD, 0.35)
    for tried in ([last, fewer, more], [more, fewer, last]):
        assert told(tried, last) is fewer


def test_a_few_seconds_of_validation_do_not_decide() -> None:
    last = trial("presliding gravity_load", HELD, 0.40, unseen=0.8)
    plain = trial("coulomb_friction gravity_load", HELD, 0.41, unseen=1.2)
    assert last.score.validation_rmse_deg < 0.7 * plain.score.validation_rmse_deg
    assert told([last, plain], last) is plain


def test_samples_unlike_the_fitted_ones_do_not_decide() -> None:
    """Fitted to the validation samples as well, the larger model errs less there, too."""
    last = trial("supply_sag", HELD, 0.26, unseen=2.4)
    larger = trial("torque_saturation coulomb_friction gravity_load", HELD, 0.10, unseen=10.0)
    both = trial("torque_saturation coulomb_friction gravity_load", HELD, 0.12)
    assert CRITERION.overall_penalised_error(larger.score) > CRITERION.overall_penalised_error(
        last.score
    )
    scores = {last.key: last.score, larger.key: both.score}
    found = fewest_assumptions(
        [last, larger], last, CRITERION, lambda one: True, lambda one: scores[one.key]
    )
    assert found is larger


def test_no_model_is_told_that_does_not_need_all_its_effects() -> None:
    last = trial("coulomb_friction", FREE, 0.40)
    other = trial("coulomb_friction gravity_load", HELD, 0.30)
    assert told([last, other], last, lambda one: one is last) is last


def test_no_effect_is_left_out_that_would_be_accepted() -> None:
    """On the fitted samples it changes little, on those that validate much."""
    last = trial("coulomb_friction gravity_load", FREE, 0.40, unseen=0.5)
    held = trial("coulomb_friction gravity_load", HELD, 0.40, unseen=0.5)
    fewer = trial("gravity_load", HELD, 0.41, unseen=0.9)
    error = CRITERION.overall_penalised_error
    assert error(fewer.score) < error(held.score) + CRITERION.policy.effect_penalty
    assert told([last, held, fewer], last) is held
