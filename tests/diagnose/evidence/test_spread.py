"""An error that parameters within their sigma may make is no sign of a missing effect."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servosight.diagnose import LadderStep, Verdict
from servosight.diagnose.evidence import Evidence, Stability, partial
from servosight.diagnose.evidence._spread import BY_CHANCE, FARTHER, Spread, spread_of
from servosight.diagnose.residuals import TEST, Judged
from servosight.diagnose.result.caveats import compensating
from servosight.diagnose.result.wording import Levels, headline_and_summary
from servosight.diagnose.selection import ModelSelection, Split, Trial
from servosight.identify.fit import Solution
from servosight.models.core import Recording
from servosight.models.effects import catalogue

TIME_S = np.arange(0.0, 8.0, 0.02)
NOISE_DEG = 0.2


def chirped() -> Recording:
    """A lag of 0.1 s that follows a chirp, and noise."""
    command = 8.0 * np.sin(2.0 * np.pi * (0.3 + 0.15 * TIME_S) * TIME_S)
    angle = np.zeros_like(command)
    for place in range(1, command.size):
        angle[place] = angle[place - 1] + 0.2 * (command[place - 1] - angle[place - 1])
    noise = NOISE_DEG * np.random.default_rng(3).normal(size=TIME_S.size)
    return Recording("run", TIME_S, command, TIME_S, angle + noise)


def linear() -> tuple[ModelSelection, Trial]:
    models = ModelSelection(Split.of([chirped()]), catalogue())
    return models, models.linear()


def test_the_spread_is_that_of_the_covariance() -> None:
    """Truth: to first order the mean square change of a prediction is the mean of diag(J S J'), S
    the covariance and J the slopes of the test samples. With T and xi as one direction each draw is
    a chi-square of one or two: of 64, eight a seed, the rms is within 9 %, and 2.3 times it.
    """
    models, trial = linear()
    fit = trial.fit
    covariance = np.nan_to_num(fit.uncertainty.covariance)
    usual = models.tested(trial)[0]
    test = usual.uses == TEST
    slopes = []
    for place in range(len(covariance)):
        step = 0.1 * np.sqrt(covariance[place, place])
        point = fit.outcome.point.copy()
        point[place] += step
        moved = models.tested(models.trial(Solution.at(fit.problem, point)))[0]
        away = moved.predicted_deg[test] - usual.predicted_deg[test]
        slopes.append(away / step if step > 0.0 else np.zeros_like(away))
    rows = np.array(slopes)
    expected = float(np.sqrt(np.mean(np.einsum("in,ij,jn->n", rows, covariance, rows))))
    found = spread_of(models, trial)
    each = [spread_of(models, trial, seed).test_deg for seed in range(8)]
    assert float(np.sqrt(np.mean(np.square(each)))) == pytest.approx(expected, rel=0.2)
    assert found.fitted_deg == pytest.approx(found.test_deg, rel=0.5)
    assert found == spread_of(models, trial)
    assert found.words(NOISE_DEG) is None


@pytest.mark.parametrize(
    ("share", "times", "said"),
    [
        (0.98 * BY_CHANCE, 9.0, False),
        (1.02 * BY_CHANCE, 9.0, True),
        (1.02 * BY_CHANCE, 0.98 * FARTHER, False),
        (1.02 * BY_CHANCE, 1.02 * FARTHER, True),
    ],
)
def test_half_of_the_squared_error_and_more_than_on_fitted_data_is_said(
    share: float, times: float, said: bool
) -> None:
    test_deg = float(np.sqrt(share))
    words = Spread(fitted_deg=test_deg / times, test_deg=test_deg).words(1.0)
    assert (words is not None) == said
    assert words is None or "within their sigma" in words


@pytest.mark.parametrize(("spread", "chance"), [(0.1, False), (0.9, True)])
def test_nothing_is_called_missing_on_account_of_chance(spread: float, chance: bool) -> None:
    angle = np.sin(TIME_S)
    recording = Recording("run", TIME_S, angle, TIME_S, angle + 1.0)
    judged = Judged(recording, angle, np.full(TIME_S.size, TEST, dtype=np.int8))
    left = partial((3.0, 1.0), 0.03, [], [judged], None, Spread(fitted_deg=0.01, test_deg=spread))
    assert left.by_chance is chance
    assert ("within their sigma" in left.sentence) is chance
    first = LadderStep(
        added=None, removed=None, effects=(), train_rmse_deg=3.0, validation_rmse_deg=3.0,
        held_out_rmse_deg=3.0, explained=False, parameters={}, own=(),
    )  # fmt: skip
    last = replace(first, added="backlash", effects=("backlash",), held_out_rmse_deg=1.0)
    levels = Levels(noise_deg=0.03, tolerance_deg=0.01, floor_deg=0.0316)
    known = Evidence(regimes=(), repeated=None, unexplained=left, detectable=())
    _, summary = headline_and_summary(
        Verdict.UNEXPLAINED, [first, last], [], None, levels, known, Stability(), ()
    )
    assert ("something remains" in summary) is not chance
    assert bool(compensating(Verdict.UNEXPLAINED, last.effects, known, False)) is not chance
