"""The ladder as a diagnosis reports it: each step's errors, parameters and what the model does."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

from servosight.diagnose.evidence import taken
from servosight.diagnose.residuals import EXPLAINED, held_out_fit_percent, held_out_rms
from servosight.diagnose.result import LadderStep
from servosight.diagnose.result.caveats import held_otherwise
from servosight.diagnose.selection import AcceptanceCriterion, ModelSelection, Step
from servosight.identify.fit import dynamics, parameter_table, step_size_deg
from servosight.identify.foreign import base_of
from servosight.models.core import Actuator, Estimate, Table


def ladder_steps(
    models: ModelSelection, criterion: AcceptanceCriterion, steps: Sequence[Step]
) -> Table[LadderStep]:
    """The steps with the share of the first one's squared test error that each removes.

    The first and the last step are reported with profiles of the likelihood where a parabola does
    not hold. These take a fit for each distance: on a step between, whose model was left, its
    sigmas are the Jacobian's.
    """
    ends = 0, len(steps) - 1
    reported = [_step(models, criterion, step, i in ends) for i, step in enumerate(steps)]
    shares = taken([step.held_out_rmse_deg for step in reported])
    otherwise = ((), *(_held(one, other) for one, other in itertools.pairwise(steps)))
    return Table(
        replace(step, taken=share, held=held, warnings=(*held, *step.warnings))
        for step, share, held in zip(reported, shares, otherwise, strict=True)
    )


def _held(before: Step, step: Step) -> tuple[str, ...]:
    """What a step holds otherwise than the one before it."""
    earlier, fit = before.trial.fit, step.trial.fit
    values = earlier.problem.values(earlier.outcome.point)
    return held_otherwise(earlier.problem.held, fit.problem.held, values)


def _step(
    models: ModelSelection, criterion: AcceptanceCriterion, step: Step, profiled: bool
) -> LadderStep:
    fit, score = step.trial.fit, step.trial.score
    table, warnings = fit.uncertainty.shared_estimates(profiled)
    judged = models.tested(step.trial)
    held_out = held_out_rms(judged)
    covariance = fit.uncertainty.matrix(table)
    actuator = Actuator({**table, "bias": Estimate(0.0, None, "deg")}, step.trial.effects)
    size_deg = step_size_deg(models.recordings)
    return LadderStep(
        added=step.added,
        removed=step.removed,
        effects=step.trial.effects,
        train_rmse_deg=score.train_rmse_deg,
        validation_rmse_deg=step.trial.validation_rmse_deg,
        held_out_rmse_deg=held_out,
        explained=held_out <= EXPLAINED * criterion.floor_deg,
        parameters=parameter_table(table, fit.uncertainty.own_estimates("bias")),
        own=models.own(step.trial),
        warnings=(*fit.notes, *warnings),
        correlation=covariance.correlation,
        dynamics=dynamics(actuator, covariance, size_deg, models.catalogue),
        base=base_of(models.catalogue),
        fit_percent=held_out_fit_percent(judged, criterion.floor_deg),
        sampling_correlation=fit.uncertainty.matrix(table, sampling=True).correlation,
        shared_error=fit.uncertainty.shared_shares(table),
    )
