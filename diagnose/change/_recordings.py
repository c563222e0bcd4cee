"""The change of a servo between two sets of recordings: one model fitted to each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from servosight.diagnose._compare import compare
from servosight.diagnose._diagnose import diagnose
from servosight.diagnose.change._change import (
    ChangePolicy,
    ComparedServo,
    ServoChange,
    change_between,
)
from servosight.diagnose.residuals import EXPLAINED
from servosight.diagnose.selection import PriorKnowledge
from servosight.identify.fit import Fit, identify
from servosight.models.core import (
    InputError,
    Recording,
    StageProgress,
    degrees,
    either,
    silent,
)
from servosight.models.effects import Effect, select


def change_in_recordings(
    a: Sequence[Recording],
    b: Sequence[Recording],
    *,
    catalogue: Mapping[str, Effect],
    effects: Sequence[str] | None = None,
    fix: Mapping[str, float] | None = None,
    progress: StageProgress = silent,
) -> ServoChange:
    """Fit the same model to ``a`` and to ``b``, each set jointly, and compare the parameters.

    ``effects`` are those of the model; None finds them by a diagnosis of either set: all that were
    found in one of them; with too few samples for that the linear model, as a warning says. What a
    model lacks shows as a change of what it has: so a warning says where an error stays above the
    floor. ``fix`` holds parameters of the model, such as ``{"k": 1.0}``, in both. InputError for an
    unknown effect, and for a parameter to hold that the model does not have.
    """
    policy = ChangePolicy()
    fewest = min(sum(one.time_s.size for one in side) for side in (a, b))
    short = effects is None and fewest < policy.fewest
    if short:
        effects = ()
    elif effects is None:
        prior = PriorKnowledge.of(catalogue, fix=fix)
        found = [
            diagnose(one, catalogue=catalogue, auto=True, prior=prior, progress=progress)
            for one in (a, b)
        ]
        effects = [name for one in found for name in one.effects]
    chosen = _without_contained(select(catalogue, effects), catalogue)
    progress("fitting both", 0, 1)
    fits = [
        identify(one, chosen, catalogue=catalogue, method="gradient", fix=fix) for one in (a, b)
    ]
    crossed = [
        compare(fit.actuator, other, catalogue=catalogue).rmse_deg
        for fit, other in zip(fits, (b, a), strict=True)
    ]
    first, second = (
        ComparedServo(
            name=name,
            effects=fit.effects,
            recordings=fit.recordings,
            rmse_deg=fit.rmse_deg,
            floor_deg=fit.floor_deg,
            other_rmse_deg=error,
        )
        for name, fit, error in zip("ab", fits, reversed(crossed), strict=True)
    )
    return change_between(
        fits[0].actuator,
        fits[1].actuator,
        catalogue=catalogue,
        sides=(first, second),
        warnings=[*_warnings(fits), *([_short(fewest, policy)] if short else [])],
        policy=policy,
    )


def refuse_fitting(effects: Sequence[str] | None, fix: Mapping[str, float] | None) -> None:
    """Raise InputError where it is said what to fit and a model is compared, which is not fitted.

    >>> refuse_fitting(None, {})
    """
    if effects is not None or fix:
        raise InputError(
            f"compare: a model is not fitted, expected "
            f"{either('effects and fix', '--effects and --fix')} only where both sides are "
            f"recordings; leave them out"
        )


def _short(fewest: int, policy: ChangePolicy) -> str:
    return (
        f"{fewest} samples are too few to find effects for a comparison, for which at least "
        f"{policy.fewest} are expected: linear models are compared; --effects names others"
    )


def _without_contained(effects: Sequence[str], catalogue: Mapping[str, Effect]) -> list[str]:
    """Without the special cases of others among them."""
    special = {name for effect in effects for name in catalogue[effect].contains}
    return [name for name in effects if name not in special]


def _warnings(fits: Sequence[Fit]) -> list[str]:
    found = []
    shared = [one for one in fits[0].warnings if one in fits[1].warnings]
    for side, fit in zip("ab", fits, strict=True):
        if fit.rmse_deg > EXPLAINED * fit.floor_deg:
            found.append(
                f"the model misses something in {side}: its error is {degrees(fit.rmse_deg)}, the "
                f"floor {degrees(fit.floor_deg)}; a change of what it lacks shows as a change of "
                f"what it has"
            )
        found += [f"{side}: {one}" for one in fit.warnings if one not in shared]
    return [*found, *shared]
