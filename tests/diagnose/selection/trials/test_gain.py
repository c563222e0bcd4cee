"""What the selection takes for granted where a servo measures its angle itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servosight.diagnose import Diagnosis, diagnose
from servosight.diagnose.selection import ModelSelection, PriorKnowledge, Split
from servosight.identify.problem import offered
from servosight.models.core import Recording
from servosight.models.effects import catalogue

TIME_S = np.arange(0.0, 3.0, 0.02)
COMMAND_DEG = 10.0 * np.sin(3.0 * TIME_S)
NOISE_DEG = 0.01 * np.random.default_rng(0).normal(size=TIME_S.size)
READ = Recording(
    "run", TIME_S, COMMAND_DEG, TIME_S, 0.9 * COMMAND_DEG + 1.0 + NOISE_DEG, side="sensor"
)


OTHERS = catalogue().keys() - {"coulomb_friction", "backlash", "linkage_geometry"}
"""Ruled out where a test is of the words, not of the choice."""


def models_of(*recordings: Recording, known: PriorKnowledge | None = None) -> ModelSelection:
    split = Split.of(recordings)
    return ModelSelection(split, offered(catalogue(), recordings), known or PriorKnowledge())


def test_k_is_held_at_one_where_the_loop_is_closed_on_the_measured_angle() -> None:
    models = models_of(READ)
    fit = models.linear().fit
    assert fit.problem.values(fit.outcome.point)["k"] == 1.0
    linear = models.unloaded()
    assert linear is not None
    assert linear.key == models.linear().key


def test_the_user_s_k_counts_and_a_surface_s_k_is_fitted() -> None:
    given = models_of(READ, known=PriorKnowledge(fixed={"k": 0.9})).linear().fit
    assert given.problem.values(given.outcome.point)["k"] == 0.9
    seen = models_of(replace(READ, side="surface")).linear().fit
    assert abs(seen.problem.values(seen.outcome.point)["k"] - 0.9) < 0.01


def test_bias_and_time_constant_are_those_of_a_servo() -> None:
    """5 deg and 0.3 s at the most; from a surface's angle nothing is known of either."""
    far = replace(READ, angle_deg=READ.angle_deg + 50.0)
    for side, bias_deg, slow_s in (("sensor", 5.0, 0.3), ("surface", 720.0, 2.0)):
        models = models_of(replace(far, side=side))  # type: ignore[arg-type]
        problem = models.linear().fit.problem
        high = dict(zip((c.name for c in problem.coordinates), problem.bounds[1], strict=True))
        assert np.isclose(high["bias"], bias_deg)
        assert np.isclose(np.exp(high["T"]), slow_s)


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    return diagnose([READ], prior=PriorKnowledge.of(catalogue(), without_effects=[*OTHERS]))


def test_a_warning_says_what_is_taken_for_granted(found: Diagnosis) -> None:
    assert any("servo's own sensor" in text and "--fix k" in text for text in found.warnings)
    assert {one.effect for one in found.candidates} == {"coulomb_friction"}  # at the servo itself
    free = PriorKnowledge.of(catalogue(), without_effects=[*OTHERS])
    seen = diagnose([replace(READ, side="surface")], prior=free)
    assert not any("sensor" in text for text in seen.warnings)
    given = diagnose([READ], prior=replace(free, fixed={"k": 0.9}))
    assert any("own sensor" in text and "--fix" not in text for text in given.warnings)


def test_the_first_step_shows_the_linear_model_with_the_k_that_fits(
    found: Diagnosis,
) -> None:
    """Else the error would fall from that of a model that nobody would take."""
    (first,) = found.ladder
    assert abs(first.parameters["k"].value - 0.9) < 0.01  # type: ignore[union-attr]
    given = models_of(READ, known=PriorKnowledge(with_effects=("gravity_load",)))
    assert given.opening() is given.first()
