"""The difference of two models, parameter by parameter, with its significance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import ClassVar

import numpy as np
from scipy.special import chdtrc, ndtri

from servosight.diagnose._report import write_report
from servosight.diagnose.change._words import (
    different_effects,
    meaning,
    mixed_words,
    sentence,
    summary_words,
)
from servosight.identify.fit import Dynamics, dynamics
from servosight.identify.uncertainty import Matrix
from servosight.models.core import (
    CORE,
    Actuator,
    Array,
    Parameter,
    Result,
    Table,
    kept_covariance,
)
from servosight.models.effects import Effect

STEP_DEG = 10.0
"""The step of the command to which the responses of both are compared."""


@dataclass(frozen=True, kw_only=True)
class ChangePolicy:
    """``chance``: a parameter counts as changed where chance alone would make any of those compared
    differ so much in at most this share of cases (3 sigma of one; Bonferroni's correction for
    several). ``confidence``: of the interval that bounds what is not found to have changed.
    ``fewest``: samples of either servo from which on effects are looked for. ``worse``: the servos
    differ, in whatever parameter, where the other's model errs so many times as much as the own.
    """

    chance: float = 0.0027
    confidence: float = 0.95
    fewest: int = 200
    worse: float = 2.0


@dataclass(frozen=True, kw_only=True)
class ParameterChange:
    """One parameter in both: ``a`` and ``b`` with their sigmas, ``b`` less ``a`` with its own.

    ``sigmas`` is that difference over its sigma, None where a sigma is unknown or where the models
    hold different effects: the same parameter then stands for different things. ``changed`` says
    whether it is significant. Where one model lacks the effect, ``only_in`` is the other ("a" or
    "b"), and nothing is known of the value here.
    """

    name: str
    unit: str
    a: float | None
    a_sigma: float | None
    b: float | None
    b_sigma: float | None
    difference: float | None
    sigma: float | None
    sigmas: float | None
    changed: bool
    only_in: str | None
    sentence: str


@dataclass(frozen=True, kw_only=True)
class ComparedServo:
    """One of the two: its name, effects, recordings, and how well its model fits them.

    ``dynamics`` are bandwidth, step metrics and the like for a step by :data:`STEP_DEG`, with
    sigmas where the covariance of the parameters is known.
    """

    name: str
    effects: tuple[str, ...]
    recordings: tuple[str, ...] = ()
    rmse_deg: float | None = None
    floor_deg: float | None = None
    other_rmse_deg: float | None = None
    dynamics: Dynamics | None = None


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class ServoChange(Result):
    """What differs between two models, or between the servos of two sets of recordings.

    ``p`` is the probability of a difference this large by chance if nothing had changed: of
    ``chi_square`` over the ``freedom`` parameters that both have with a sigma; None without any.
    ``other_rmse_deg`` of a side is the error of the other's model on its recordings.

    >>> import servosight as ss
    >>> fits = [ss.identify(ss.simulate(seed=seed), method="gradient") for seed in (3, 4)]
    >>> change = ss.compare(*fits)
    >>> change.changed, [one.name for one in change.parameters]
    ((), ['k', 'T', 'xi'])
    """

    TYPE: ClassVar[str] = "change"

    headline: str
    summary: str
    a: ComparedServo
    b: ComparedServo
    parameters: Table[ParameterChange]
    chi_square: float | None
    freedom: int
    p: float | None
    sentences: tuple[str, ...]
    warnings: tuple[str, ...]

    @property
    def changed(self) -> tuple[str, ...]:
        """Names of the parameters that have changed, the surest first."""
        found = [one for one in self.parameters if one.changed]
        return tuple(one.name for one in sorted(found, key=lambda one: -abs(one.sigmas or 0.0)))

    def report(self, path: Path | str, *, catalogue: Mapping[str, Effect] | None = None) -> None:
        """Write a report to read in a browser; ``catalogue`` holds the effects of a plugin."""
        write_report(path, self, None, catalogue)


def limit_sigmas(count: int, policy: ChangePolicy = ChangePolicy()) -> float:
    """From how many sigmas on one of ``count`` parameters counts as changed.

    >>> round(limit_sigmas(1), 2), round(limit_sigmas(4), 2)
    (3.0, 3.4)
    """
    return float(-ndtri(policy.chance / (2.0 * max(count, 1))))


def change_between(
    a: Actuator,
    b: Actuator,
    *,
    catalogue: Mapping[str, Effect],
    sides: tuple[ComparedServo, ComparedServo] | None = None,
    warnings: Sequence[str] = (),
    policy: ChangePolicy = ChangePolicy(),
) -> ServoChange:
    """``b`` against ``a``; their ``bias``, which belongs to the mounting, is left out.

    Parameters of models of which either has no covariance, which a fit leaves in its card, are
    taken for independent.

    >>> from servosight.models.core import Estimate
    >>> values = {"k": 1.0, "T": 0.02, "xi": 0.6, "bias": 0.0}
    >>> old, new = (Actuator({n: Estimate(v * f, 0.01 * v, "") for n, v in values.items()})
    ...             for f in (1.0, 1.1))
    >>> change_between(old, new, catalogue={}).changed
    ('k', 'T', 'xi')
    """
    shared = _parameters(a, b, catalogue)
    alike = set(a.effects) == set(b.effects)
    limit = limit_sigmas(len(shared), policy)
    reach = float(-ndtri((1.0 - policy.confidence) / 2.0))
    rows = [_row(name, q, a, b, limit, reach, alike) for name, q in shared.items()]
    covariances = [_covariance(one) for one in (a, b)]
    chi_square, freedom = _chi_square(rows, covariances)
    p = float(chdtrc(freedom, chi_square)) if freedom else None
    first, second = sides or (
        ComparedServo(name="a", effects=a.effects),
        ComparedServo(name="b", effects=b.effects),
    )
    changed = sorted((one for one in rows if one.changed), key=lambda one: -abs(one.sigmas or 0.0))
    same = [one.name for one in rows if not one.changed and one.sigmas is not None and one.sigma]
    found = [one.sentence for one in changed]
    if alike:
        unknown = [one.name for one in rows if one.sigmas is None]
        headline, summary = summary_words(
            found,
            same,
            unknown,
            p,
            _differ(first, second, policy),
            together=p is not None and p < policy.chance,
        )
        notes = warnings
    else:
        headline, summary = mixed_words(a.effects, b.effects)
        notes = (different_effects(a.effects, b.effects), *warnings)
    means = [meaning(one.name, one.a, one.b, catalogue) for one in changed]
    return ServoChange(
        headline=headline,
        summary=summary,
        a=replace(first, dynamics=dynamics(a, covariances[0], STEP_DEG, catalogue)),
        b=replace(second, dynamics=dynamics(b, covariances[1], STEP_DEG, catalogue)),
        parameters=Table(rows),
        chi_square=chi_square if freedom else None,
        freedom=freedom,
        p=p,
        sentences=(*found, *dict.fromkeys(means)),
        warnings=tuple(notes),
    )


def _differ(a: ComparedServo, b: ComparedServo, policy: ChangePolicy) -> bool:
    """True where either servo is predicted far worse by the other's model than by its own."""
    for side in (a, b):
        if side.rmse_deg is not None and side.other_rmse_deg is not None:
            own = max(side.rmse_deg, side.floor_deg or 0.0)
            if side.other_rmse_deg > policy.worse * own:
                return True
    return False


def _parameters(a: Actuator, b: Actuator, catalogue: Mapping[str, Effect]) -> dict[str, Parameter]:
    """Those of the core and of all effects of either."""
    found = {parameter.name: parameter for parameter in CORE}
    for effect in dict.fromkeys((*a.effects, *b.effects)):
        found |= {f"{effect}.{q.name}": q for q in catalogue[effect].parameters}
    return found


def _row(
    name: str,
    parameter: Parameter,
    a: Actuator,
    b: Actuator,
    limit: float,
    reach: float,
    alike: bool,
) -> ParameterChange:
    one, other = a.parameters.get(name), b.parameters.get(name)
    difference = sigma = ratio = None
    if one is not None and other is not None:
        difference = other.value - one.value
        if one.sigma is not None and other.sigma is not None:
            sigma = float(np.hypot(one.sigma, other.sigma))
            ratio = difference / sigma if sigma > 0.0 else (0.0 if difference == 0.0 else None)
    ratio = ratio if alike else None
    changed = ratio is not None and abs(ratio) >= limit
    bound = None if sigma is None or difference is None else abs(difference) + reach * sigma
    return ParameterChange(
        name=name,
        unit=parameter.unit,
        a=None if one is None else one.value,
        a_sigma=None if one is None else one.sigma,
        b=None if other is None else other.value,
        b_sigma=None if other is None else other.sigma,
        difference=difference,
        sigma=sigma,
        sigmas=ratio,
        changed=changed,
        only_in="b" if one is None else "a" if other is None else None,
        sentence=sentence(name, parameter.unit, (one, other), ratio, changed, bound, alike),
    )


def _covariance(model: Actuator) -> Matrix | None:
    """That of its shared parameters, NaN for those that have no sigma; None where unknown."""
    kept = kept_covariance(model.provenance, model.parameters)
    if kept is None:
        return None
    names = tuple(name for name in model.parameters if name != "bias")
    values = np.full((len(names), len(names)), np.nan)
    at = [names.index(name) for name in kept[0]]
    values[np.ix_(at, at)] = kept[1]
    return Matrix(names, values)


def _chi_square(
    rows: Sequence[ParameterChange], covariances: Sequence[Matrix | None]
) -> tuple[float, int]:
    """d' C^-1 d over the parameters that both have with a sigma above 0, and their number."""
    able = [
        one for one in rows if one.sigmas is not None and one.sigma is not None and one.sigma > 0.0
    ]
    if not able:
        return 0.0, 0
    covariance = np.diag([float(one.sigma or 0.0) ** 2 for one in able])
    among = [_among(able, one) for one in covariances if one is not None]
    if len(among) == len(covariances):
        both = np.sum(among, axis=0)
        if np.all(np.isfinite(both)) and np.all(np.diag(both) > 0.0):  # as a card may not be
            covariance = both
    difference = np.array([one.difference for one in able], dtype=np.float64)
    scale = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(scale, scale)
    scaled = difference / scale
    return float(scaled @ np.linalg.pinv(correlation, 1e-10) @ scaled), len(able)


def _among(rows: Sequence[ParameterChange], covariance: Matrix) -> Array:
    at = [covariance.names.index(one.name) for one in rows]
    return np.asarray(covariance.values[np.ix_(at, at)])
