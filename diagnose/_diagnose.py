"""From recordings to the missing effect: the diagnosis that the user reads."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from servosight.diagnose.discrepancy import Law, find_law
from servosight.diagnose.experiment import Proposal, propose
from servosight.diagnose.residuals import Finding, Window, findings, worst_windows
from servosight.diagnose.selection import (
    MIN_EVIDENCE,
    Bar,
    Climb,
    Climber,
    Laboratory,
    Look,
    Progress,
    Rung,
    Trial,
    alternatives,
    confounded,
    evidence,
    silent,
)
from servosight.identify.fit import floor_deg, parameters_json
from servosight.identify.problem import TOLERANCE_SHARE, joint_noise_deg, thinned
from servosight.identify.uncertainty import estimates, own_estimates
from servosight.models.core import Actuator, Estimate, Recording, views
from servosight.models.effects import Effect
from servosight.models.excitation import Limits

Verdict = Literal["no_effect_missing", "explained", "unexplained"]


@dataclass(frozen=True)
class Step:
    """A rung of the ladder with its parameters and their uncertainty."""

    rung: Rung
    explained: bool
    parameters: Mapping[str, Estimate]
    biases: tuple[Estimate, ...]
    warnings: tuple[str, ...]

    @property
    def trial(self) -> Trial:
        """The fitted model of this step."""
        return self.rung.trial

    def to_json(self) -> dict[str, Any]:
        """Its JSON (docs/json.md); ``removed`` is added where an effect was taken out."""
        entry: dict[str, Any] = {
            "added": self.rung.added,
            "effects": list(self.trial.effects),
            "train_rmse_deg": self.trial.train_rmse_deg,
            "held_out_rmse_deg": self.trial.held_out_rmse_deg,
            "explained": self.explained,
            "parameters": parameters_json(self.parameters, self.biases),
        }
        if self.rung.removed is not None:
            entry["removed"] = self.rung.removed
        return entry


@dataclass(frozen=True)
class Candidate:
    """One effect tried alone on the linear model."""

    effect: str
    trial: Trial
    held_out_rmse_deg: float
    evidence: float
    confounded_with: tuple[str, ...]

    def to_json(self) -> dict[str, Any]:
        """Its JSON (docs/json.md)."""
        return {
            "effect": self.effect,
            "held_out_rmse_deg": self.held_out_rmse_deg,
            "evidence": self.evidence,
            "confounded_with": list(self.confounded_with),
        }


@dataclass(frozen=True)
class Diagnosis:
    """What is missing, how sure that is, where the linear model fails and what adding gains."""

    noise_deg: float
    floor_deg: float
    tolerance_deg: float
    verdict: Verdict
    effects: tuple[str, ...]
    ladder: tuple[Step, ...]
    candidates: tuple[Candidate, ...]
    where: tuple[Window, ...]
    findings: tuple[Finding, ...]
    alternatives: tuple[tuple[str, ...], ...]
    next_experiment: str
    proposal: Proposal | None
    seconds: float
    actuator: Actuator
    law: Law | None = None

    def to_json(self) -> dict[str, Any]:
        """Its JSON (docs/json.md)."""
        return {
            "schema": 1,
            "noise_deg": self.noise_deg,
            "floor_deg": self.floor_deg,
            "verdict": self.verdict,
            "effects": list(self.effects),
            "ladder": [step.to_json() for step in self.ladder],
            "candidates": [candidate.to_json() for candidate in self.candidates],
            "where": [window.to_json() for window in self.where],
            "findings": [finding.to_json() for finding in self.findings],
            "alternatives": [list(effects) for effects in self.alternatives],
            "next_experiment": self.next_experiment,
            "proposal": None if self.proposal is None else self.proposal.to_json(),
            "law": None if self.law is None else self.law.to_json(),
            "seconds": self.seconds,
        }


def diagnose(
    recordings: Sequence[Recording],
    validate: Sequence[Recording] = (),
    *,
    catalogue: Mapping[str, Effect],
    auto: bool = False,
    tolerance: float | None = None,
    limits: Limits | None = None,
    progress: Progress = silent,
) -> Diagnosis:
    """Compare the linear model with recordings, rank what could be missing; climb with ``auto``.

    ``validate`` recordings are held out whole; without them, every third second is. ``tolerance``
    [deg] is what no model need reach (default 0.05 % of the moved range). ``limits`` bound the next
    experiment (default: what the recordings' commands have used).
    """
    began = time.perf_counter()
    recordings, validate = views(recordings), views(validate)
    every = (*recordings, *validate)
    noise = joint_noise_deg(every)
    allowed = tolerance
    if allowed is None:
        allowed = TOLERANCE_SHARE * max(recording.moved_range_deg for recording in every)
    floor = floor_deg(every, noise, allowed)
    bar = Bar(floor, allowed)
    scored, _ = thinned(every)
    recordings, validate = scored[: len(recordings)], scored[len(recordings) :]
    laboratory = _laboratory(tuple(recordings), tuple(validate), catalogue, bar)
    climber = Climber(laboratory, bar, progress)
    climb = climber.climb() if auto else climber.first_step()
    linear, last = climb.rungs[0].trial, climb.rungs[-1].trial
    steps = tuple(_step(rung, bar) for rung in climb.rungs)
    look = Look(noise, allowed)
    candidates = _candidates(laboratory, climb, look)
    rivals = _rivals(laboratory, climb, look, bar, auto)
    law = _law(laboratory, linear, last, bar, noise, progress) if auto else None
    proposal = propose(rivals, laboratory, noise, allowed, limits) if len(rivals) > 1 else None
    return Diagnosis(
        noise,
        floor,
        allowed,
        _verdict(linear, last, bar),
        _in_order(climb),
        steps,
        candidates,
        tuple(worst_windows(linear.judged)),
        findings(linear.judged, floor, noise),
        tuple(rival.effects for rival in rivals[1:]),
        _next_experiment(proposal, candidates, linear, last, bar, auto),
        proposal,
        time.perf_counter() - began,
        _actuator(steps[-1], recordings),
        law,
    )


def _laboratory(
    recordings: tuple[Recording, ...],
    validate: tuple[Recording, ...],
    catalogue: Mapping[str, Effect],
    bar: Bar,
) -> Laboratory:
    """Where what is missing shows in the held-out samples alone, another third is held out.

    No effect can be fitted to what the fit does not see.
    """
    laboratory = Laboratory(recordings, validate, catalogue)
    linear = laboratory.linear()
    if bar.settled(linear) and not bar.explained(linear) and not validate:
        return laboratory.anew(third=1)
    return laboratory


def _step(rung: Rung, bar: Bar) -> Step:
    fit = rung.trial.fit
    arguments = (fit.problem, fit.outcome.point, fit.jacobian, fit.outcome.cost)
    table, warnings = estimates(*arguments)
    return Step(
        rung,
        bar.explained(rung.trial),
        table,
        own_estimates(*arguments, "bias"),
        tuple(warnings),
    )


def _law(
    laboratory: Laboratory, linear: Trial, last: Trial, bar: Bar, noise: float, progress: Progress
) -> Law | None:
    """What the ladder left, as a law; None where it left nothing or nothing lawful."""
    if bar.explained(last):
        return None
    progress("looking for a law of what remains", 0, 1)
    bases = [linear, last] if last.effects else [linear]
    return find_law(laboratory, bases, bar, noise)


def _verdict(linear: Trial, last: Trial, bar: Bar) -> Verdict:
    if not bar.explained(last):
        return "unexplained"
    return "explained" if last.effects else "no_effect_missing"


def _in_order(climb: Climb) -> tuple[str, ...]:
    """The final effects in the order in which they were added."""
    final = climb.rungs[-1].trial.effects
    added = [rung.added for rung in climb.rungs if rung.added in final]
    return tuple(dict.fromkeys(added))


def _candidates(laboratory: Laboratory, climb: Climb, look: Look) -> tuple[Candidate, ...]:
    linear = climb.rungs[0].trial
    groups = confounded(climb.singles, linear, look, laboratory.whole)
    found = []
    for trial in climb.singles:
        (name,) = trial.effects
        gain = evidence(trial, linear, look.tolerance_deg)
        found.append(Candidate(name, trial, trial.held_out_rmse_deg, gain, groups[name]))
    return tuple(sorted(found, key=lambda one: -one.evidence))


def _rivals(
    laboratory: Laboratory, climb: Climb, look: Look, bar: Bar, auto: bool
) -> tuple[Trial, ...]:
    """The model that was chosen, or would be next, and those that it cannot be told from.

    None where the linear model is all that is left.
    """
    linear, chosen = climb.rungs[0].trial, climb.rungs[-1].trial
    if not auto and not bar.explained(linear):
        chosen = climb.singles[0]
    if not chosen.effects or evidence(chosen, linear, bar.tolerance_deg) <= MIN_EVIDENCE:
        return ()
    tried = laboratory.notebook.values()
    return (chosen, *alternatives(chosen, tried, look, laboratory.whole))


def _next_experiment(
    proposal: Proposal | None,
    candidates: Sequence[Candidate],
    linear: Trial,
    last: Trial,
    bar: Bar,
    auto: bool,
) -> str:
    """One sentence on what to do next."""
    if bar.explained(linear) and not last.effects:
        return "Nothing is missing here; to look further, use a larger and faster command."
    best = candidates[0]
    if proposal is not None:
        return proposal.sentence
    if bar.explained(last):
        return "The ladder reached the floor: confirm on a recording with another command."
    if not auto:
        if bar.earns(best.trial, linear, len(candidates)):
            return (
                f"Add {best.effect}: `servosight add MODEL.toml {best.effect} REC`, or use --auto."
            )
        return "No single effect earns its place: use --auto, which tries pairs."
    return (
        "Something remains that no catalogued effect accounts for: repeat the recording to see "
        "what repeats, at half and at double the amplitude to see what scales, and slower to see "
        "what depends on speed."
    )


def _actuator(step: Step, recordings: Sequence[Recording]) -> Actuator:
    return Actuator(
        {**step.parameters, "bias": step.biases[0]},
        step.trial.effects,
        {
            "fitted_on": [recording.name for recording in recordings],
            "held_out_rmse_deg": step.trial.held_out_rmse_deg,
            "method": "diagnose",
        },
    )
