"""A sparse law for what no catalogued effect accounts for, confirmed by simulation.

Terms are chosen by what they promise to first order (pursuit.py). Those that promise most are then
fitted with everything else by simulation, and a term stays if it shows on data that the fit has not
seen.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from servosight.diagnose.discrepancy._disturbance import Loop
from servosight.diagnose.discrepancy._matching_pursuit import FORMS, Lead, promising
from servosight.diagnose.discrepancy._plugin_codegen import draft
from servosight.diagnose.discrepancy.basis import Form, Motion
from servosight.diagnose.selection import MIN_EVIDENCE, Bar, Laboratory, Trial, criterion, evidence
from servosight.identify.fit import polish
from servosight.identify.problem import Problem
from servosight.identify.search import half_squares
from servosight.identify.uncertainty import estimates
from servosight.models.core import Array, Estimate

MOST_TERMS = 3
FINISHED = 2
"""Of the sketches of what promises most, the best are fitted to the end."""
SKETCH_BUDGET = 120
FINISH_BUDGET = 500
MIN_GAIN = 0.1
"""A term must lower the held-out rmse by this share,"""
MIN_CLOSED = 0.5
"""and the law as a whole must close this share of the gap between held-out rmse and floor."""


@dataclass(frozen=True)
class Missing:
    """The torque [deg] that a recording's model lacks, (instants,), along its motion."""

    recording: str
    motion: Motion
    torque_deg: Array
    sigma_deg: float


@dataclass(frozen=True)
class Law:
    """Terms that close most of the gap between a model's held-out error and the floor.

    ``before`` is the best model without them, ``base`` what they were added to (that or a plainer
    one), ``after`` the model with them, ``floor_deg`` what no model need beat, ``missing`` the
    torque that ``base`` lacks in each fitted recording.
    """

    before: Trial
    base: Trial
    after: Trial
    floor_deg: float
    missing: tuple[Missing, ...]

    @property
    def terms(self) -> tuple[Form, ...]:
        """The terms, in the order of the library."""
        return tuple(FORMS[name] for name in self.after.effects if name in FORMS)

    @property
    def closed(self) -> float:
        """Share of the gap between held-out rmse and floor that the terms close."""
        before, after = self.before.held_out_rmse_deg, self.after.held_out_rmse_deg
        return (before - after) / max(before - self.floor_deg, 1e-12)

    @cached_property
    def parameters(self) -> Mapping[str, Estimate]:
        """All parameters of the model with the law, and their uncertainty."""
        fit = self.after.fit
        return estimates(fit.problem, fit.outcome.point, fit.jacobian, fit.outcome.cost)[0]

    @property
    def coefficients(self) -> Mapping[str, Estimate]:
        """Those of the law's own terms, as ``term.parameter``."""
        own = {form.effect.id for form in self.terms}
        return {n: one for n, one in self.parameters.items() if n.split(".")[0] in own}

    @property
    def equation(self) -> str:
        """The terms' equations."""
        return "; ".join(form.effect.equation for form in self.terms)

    @property
    def sentence(self) -> str:
        """What the law says, and how far it goes."""
        words = ", and ".join(form.words for form in self.terms)
        share = f"{100.0 * min(self.closed, 1.0):.0f} %"
        return (
            f"The missing torque goes {words}: this closes {share} of the gap between the held-out "
            f"error and the floor."
        )

    def draft(self) -> str:
        """A plugin file with the terms as effects, to be read, named and run."""
        values = {name: one.value for name, one in self.coefficients.items()}
        return draft([form.effect for form in self.terms], values, self.sentence)

    def to_json(self) -> dict[str, Any]:
        """Terms, numbers, held-out errors before and after."""
        return {
            "terms": [
                {"form": form.effect.id, "equation": form.effect.equation, "words": form.words}
                for form in self.terms
            ],
            "coefficients": {name: one.to_json() for name, one in self.coefficients.items()},
            "added_to": list(self.base.effects),
            "held_out_before_deg": self.before.held_out_rmse_deg,
            "held_out_after_deg": self.after.held_out_rmse_deg,
            "floor_deg": self.floor_deg,
            "closed": self.closed,
            "missing_torque_rms_deg": [
                float(np.sqrt(np.mean(one.torque_deg**2))) for one in self.missing
            ],
            "sentence": self.sentence,
        }


def find_law(
    laboratory: Laboratory, bases: Sequence[Trial], bar: Bar, noise_deg: float
) -> Law | None:
    """The best law on top of one of some models; None where none closes half of the gap.

    ``bases`` are fitted models of the laboratory, the plainest first and the best last; what the
    later ones leave is looked at only where a law on the earlier ones does not reach the floor.
    """
    found: list[tuple[Trial, Trial]] = []
    for base in bases:
        found.append((base, extended(laboratory, base, bar, noise_deg)))
        if bar.explained(found[-1][1]):
            break
    base, after = max(found, key=lambda pair: criterion(pair[1], bar.tolerance_deg))
    missing = missing_torque(base, len(laboratory.recordings), noise_deg)
    law = Law(bases[-1], base, after, bar.floor_deg, missing)
    return law if law.terms and law.closed >= MIN_CLOSED else None


def missing_torque(trial: Trial, count: int, noise_deg: float) -> tuple[Missing, ...]:
    """What the model lacks in the first ``count`` of its recordings."""
    found = []
    for number in range(count):
        loop = Loop.of(trial, number, noise_deg)
        torque, sigma = loop.torque()
        found.append(Missing(trial.judged[number].recording.name, loop.motion, torque, sigma))
    return tuple(found)


def extended(laboratory: Laboratory, base: Trial, bar: Bar, noise_deg: float) -> Trial:
    """Terms added to one model, one after the other, as long as they earn their place."""
    own = laboratory.catalogue if base.effects else {}
    forms = {name: form for name, form in FORMS.items() if name not in own}
    effects = {name: form.effect for name, form in forms.items()}
    bench = laboratory.anew(catalogue={**own, **effects})
    trial = base
    for _ in range(MOST_TERMS):
        if bar.explained(trial):
            break
        ranked = promising(trial, forms, len(laboratory.recordings), noise_deg)
        better = _best(bench, trial, ranked, bar)
        if better is None or not _earns(better, trial, bar, len(forms)):
            break
        trial = _without(bench, better, base, bar)
    return trial


def _earns(trial: Trial, base: Trial, bar: Bar, tried: int) -> bool:
    lower = trial.held_out_rmse_deg <= (1.0 - MIN_GAIN) * base.held_out_rmse_deg
    gain = evidence(trial, base, bar.tolerance_deg)
    return lower and gain >= MIN_EVIDENCE + float(np.log(tried))


def _without(bench: Laboratory, trial: Trial, base: Trial, bar: Bar) -> Trial:
    """The model without the terms that a later one has made needless."""
    for name in trial.effects:
        if name in base.effects or len(trial.effects) - len(base.effects) < 2:
            continue
        smaller = bench.reduced(trial, name)
        if not _earns(trial, smaller, bar, 1):
            return _without(bench, smaller, base, bar)
    return trial


def _best(bench: Laboratory, base: Trial, leads: Sequence[Lead], bar: Bar) -> Trial | None:
    """The best of ``base`` with one form more, everything fitted anew."""
    sketches = []
    for lead in leads:
        problem = bench.problem((*base.effects, lead.name))
        point = base.fit.outcome.point
        starts = np.array([_start(problem, base, lead, x) for x in (point, point + lead.shift)])
        better = int(np.argmin(half_squares(problem.residuals(starts))))
        sketches.append(polish(problem, [starts[better]], SKETCH_BUDGET))
    sketches.sort(key=lambda fit: fit.outcome.cost)
    fits = [polish(f.problem, [f.outcome.point], FINISH_BUDGET) for f in sketches[:FINISHED]]
    trials = [bench.judge(fit) for fit in fits]
    return max(trials, key=lambda trial: criterion(trial, bar.tolerance_deg), default=None)


def _start(problem: Problem, base: Trial, lead: Lead, point: Array) -> Array:
    """A point of the base's problem, with the form's parameters where the pursuit found them."""
    old = zip(base.fit.problem.coordinates, point, strict=True)
    known = {(c.name, c.recording): float(x) for c, x in old}
    for parameter, value in zip(FORMS[lead.name].effect.parameters, lead.start, strict=True):
        known[(f"{lead.name}.{parameter.name}", None)] = value
    low, high = problem.bounds
    return np.clip([known[(c.name, c.recording)] for c in problem.coordinates], low, high)
