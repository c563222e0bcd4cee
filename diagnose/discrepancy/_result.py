"""A law as plain values: what the JSON and the report show of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from servosight.diagnose.discrepancy._disturbance import DisturbanceEstimator
from servosight.diagnose.discrepancy._law import Found, find_law, share_closed
from servosight.diagnose.discrepancy._matching_pursuit import TERMS
from servosight.diagnose.discrepancy._plugin_codegen import plugin_source
from servosight.diagnose.discrepancy.basis import BasisTerm
from servosight.diagnose.selection import AcceptanceCriterion, ModelSelection, Trial
from servosight.identify.fit import OwnValues
from servosight.models.core import Array, Estimate, Frozen, rms
from servosight.models.effects import Effect

MOST_INSTANTS = 3000
"""A longer course of the missing torque is thinned to this number of instants."""

CATALOGUED = {
    "angle_wave": "cogging",
    "angle_cube": "hinge_hardening",
    "speed_drag": "quadratic_drag",
    "dry_friction": "coulomb_friction",
    "drive_friction": "load_dependent_friction",
}
"""Terms with the equation of an effect of the catalogue: one that the search has not added."""


@dataclass(frozen=True, kw_only=True)
class LawTerm:
    """A term: its identifier, its equation, and what its torque does in words.

    ``effect`` is that of the catalogue with the same equation, None where there is none or where it
    is ruled out.
    """

    form: str
    equation: str
    words: str
    effect: str | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class MissingTorque(Frozen):
    """The torque [deg] that the model of one recording lacks along its motion, (instants,) each.

    ``time_s`` counts from the first sample; ``torque_deg`` is missing before the law, ``left_deg``
    after it; ``sigma_deg`` is the standard deviation of ``torque_deg``.
    """

    recording: str
    time_s: Array
    angle_deg: Array
    speed_deg_s: Array
    torque_deg: Array
    left_deg: Array
    sigma_deg: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Law(Frozen):
    """Terms that close most of the gap between a model's held-out error and the floor.

    ``added_to`` are the effects of the model without them, ``effects`` of that with them, whose
    ``parameters`` and ``own`` values follow. ``held_out`` errors are of the test data; ``before``
    is the last model of the ladder. ``draft`` is the source of a plugin with the terms as effects.
    """

    sentence: str
    terms: tuple[LawTerm, ...]
    coefficients: Mapping[str, Estimate]
    added_to: tuple[str, ...]
    effects: tuple[str, ...]
    parameters: Mapping[str, Estimate]
    own: tuple[OwnValues, ...]
    held_out_before_deg: float
    held_out_after_deg: float
    floor_deg: float
    closed: float
    missing_torque_rms_deg: tuple[float, ...]
    missing: tuple[MissingTorque, ...]
    draft: str

    @classmethod
    def of(cls, found: Found, floor_deg: float, noise_deg: float) -> Law:
        """The values of a law that was found."""
        fit = found.after.fit
        parameters, _ = fit.uncertainty.shared_estimates()
        terms = [TERMS[name] for name in found.after.effects if name in TERMS]
        names = {term.effect.id for term in terms}
        own = {n: one for n, one in parameters.items() if n.split(".")[0] in names}
        before, after = found.test_rms_deg
        closed = share_closed(before, after, floor_deg)
        sentence = _sentence(terms, closed)
        values = {name: one.value for name, one in own.items()}
        missing = tuple(
            _missing(found.base, found.after, number, noise_deg)
            for number in range(len(found.models.recordings))
        )
        return cls(
            sentence=sentence,
            terms=tuple(
                LawTerm(
                    form=term.effect.id,
                    equation=term.effect.equation,
                    words=term.words,
                    effect=_catalogued(term.effect.id, found.models),
                )
                for term in terms
            ),
            coefficients=own,
            added_to=found.base.effects,
            effects=found.after.effects,
            parameters=parameters,
            own=found.extended.own(found.after),
            held_out_before_deg=before,
            held_out_after_deg=after,
            floor_deg=floor_deg,
            closed=closed,
            missing_torque_rms_deg=tuple(rms(one.torque_deg) for one in missing),
            missing=tuple(_thinned(one) for one in missing),
            draft=plugin_source([term.effect for term in terms], values, sentence),
        )

    @property
    def known(self) -> tuple[str, ...]:
        """The effects of the catalogue that the terms are, empty where one of them is none."""
        known = [term.effect for term in self.terms if term.effect is not None]
        new = len(known) == len(self.terms) and not set(known) & set(self.effects)
        return tuple(known) if new else ()

    @property
    def equation(self) -> str:
        """The terms' equations."""
        return "; ".join(term.equation for term in self.terms)


def reported_law(
    models: ModelSelection,
    linear: Trial,
    last: Trial,
    criterion: AcceptanceCriterion,
    noise_deg: float,
) -> Law | None:
    """What a ladder from ``linear`` to ``last`` left, as a law; None where nothing lawful is.

    Nor where the law does not hold on the test data. Where ``last`` accounts for most of the error
    of ``linear``, its effects are taken for the right ones, and no law is looked for without them.
    """
    much = last.effects != linear.effects and criterion.leaves_much(last.score, linear.score)
    bases = [linear, last] if much else [last]
    found = find_law(models, bases, criterion, noise_deg)
    if found is None or not found.holds(criterion.floor_deg):
        return None
    return Law.of(found, criterion.floor_deg, noise_deg)


def law_effects() -> dict[str, Effect]:
    """The effects that the terms of a law are, by identifier."""
    return {name: term.effect for name, term in TERMS.items()}


def _catalogued(term: str, models: ModelSelection) -> str | None:
    """The effect that may be tried and has a term's equation."""
    name = CATALOGUED.get(term)
    able = name in models.catalogue and name not in models.known.without_effects
    return name if able else None


def _sentence(terms: list[BasisTerm], closed: float) -> str:
    """What the law says, and how far it goes."""
    words = ", and ".join(term.words for term in terms)
    share = f"{100.0 * min(closed, 1.0):.0f} %"
    return (
        f"The missing torque {words}: this closes {share} of the gap between the error on "
        f"test data and the floor."
    )


def _missing(base: Trial, after: Trial, number: int, noise_deg: float) -> MissingTorque:
    """What the model of one recording lacks before and after the law."""
    estimator = DisturbanceEstimator.of(base, number, noise_deg)
    torque, sigma = estimator.torque()
    later = DisturbanceEstimator.of(after, number, noise_deg)
    left, _ = later.torque()
    motion = estimator.motion
    return MissingTorque(
        recording=base.judged[number].recording.name,
        time_s=motion.time_s,
        angle_deg=motion.angle_deg,
        speed_deg_s=motion.speed_deg_s,
        torque_deg=torque,
        left_deg=np.interp(motion.time_s, later.motion.time_s, left),
        sigma_deg=sigma,
    )


def _thinned(one: MissingTorque) -> MissingTorque:
    count = one.time_s.size
    few = np.linspace(0, count - 1, min(MOST_INSTANTS, count)).astype(int)
    return MissingTorque(
        recording=one.recording,
        time_s=one.time_s[few],
        angle_deg=one.angle_deg[few],
        speed_deg_s=one.speed_deg_s[few],
        torque_deg=one.torque_deg[few],
        left_deg=one.left_deg[few],
        sigma_deg=one.sigma_deg,
    )
