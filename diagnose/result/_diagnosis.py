"""What a diagnosis finds, as plain values: the JSON, and all that terminal and report show."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from servosight.diagnose._report import write_report
from servosight.diagnose.discrepancy import Law
from servosight.diagnose.evidence import Regime, Repeated, Unexplained
from servosight.diagnose.experiment import Proposal
from servosight.diagnose.residuals import Finding, Window
from servosight.diagnose.result._plots import plot_ladder
from servosight.diagnose.result._recording_use import RecordingUse
from servosight.diagnose.selection import PriorKnowledge
from servosight.identify.fit import Detectable, Dynamics, OwnValues
from servosight.identify.foreign import LINEAR
from servosight.identify.transmission import Transmission
from servosight.identify.uncertainty import Matrix
from servosight.models.core import (
    Actuator,
    Estimate,
    Frozen,
    InputError,
    Result,
    Table,
    covariance_to_keep,
    spoken,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from servosight.models.effects import Effect


class Verdict(StrEnum):
    """What a diagnosis concludes.

    ``NO_EFFECT_MISSING``: the linear model is at the floor. ``EXPLAINED``: with the effects named
    the model is. ``UNEXPLAINED``: something remains that no catalogued effect accounts for.
    """

    NO_EFFECT_MISSING = "no_effect_missing"
    EXPLAINED = "explained"
    UNEXPLAINED = "unexplained"


@dataclass(frozen=True, kw_only=True)
class LadderStep(Frozen):
    """One model of the ladder.

    Errors are rms [deg]: ``train`` of the samples that were fitted, ``validation`` of those that
    chose the effects, ``held_out`` of the test's, which did neither. ``explained``: the held-out
    error is at most 1.10 times the floor. ``own`` has a line for each recording, ``correlation``
    is that of the shared parameters, ``sampling_correlation`` the same without errors that all
    samples share, of calibration and of the clocks' offset, ``shared_error`` the share of these in
    each parameter's variance. ``dynamics`` are bandwidth, step metrics and the like.
    ``taken`` is the share of the first step's squared held-out error that this step took away.
    ``base`` names what the effects act on: the linear core, or an FMU. ``fit_percent`` compares the
    held-out error with the motion (100 %: no error; None in results of earlier versions).
    ``held`` says which parameters are held from this step on that were fitted before, or the
    reverse; ``warnings`` has that as well.
    """

    added: str | None
    removed: str | None
    effects: tuple[str, ...]
    train_rmse_deg: float
    validation_rmse_deg: float
    held_out_rmse_deg: float
    explained: bool
    parameters: Mapping[str, Estimate | tuple[Estimate, ...]]
    own: tuple[OwnValues, ...]
    warnings: tuple[str, ...] = ()
    correlation: Matrix | None = None
    dynamics: Dynamics | None = None
    taken: float = 0.0
    base: str = LINEAR
    fit_percent: float | None = None
    held: tuple[str, ...] = ()
    sampling_correlation: Matrix | None = None
    shared_error: Mapping[str, float] = field(default_factory=dict)

    @property
    def change(self) -> str:
        """What the step changed: ``+ backlash``, ``- dead time``; its ``base`` of the first one."""
        signs = [f"+ {spoken(self.added)}"] if self.added else []
        signs += [f"- {spoken(self.removed)}"] if self.removed else []
        first = f"with {', '.join(map(spoken, self.effects))}" if self.effects else self.base
        return ", ".join(signs) or first

    @property
    def actuator(self) -> Actuator:
        """The model of this step, with the first recording's bias."""
        shown = {n: one for n, one in self.parameters.items() if isinstance(one, Estimate)}
        bias = self.parameters["bias"]
        return Actuator(
            {**shown, "bias": bias[0] if isinstance(bias, tuple) else bias}, self.effects
        )

    @property
    def covariance(self) -> Matrix | None:
        """Of the shared parameters, by correlation and sigmas; 0 where held, NaN where unknown."""
        if self.correlation is None:
            return None
        found = [self.parameters[name] for name in self.correlation.names]
        known = [one.sigma if isinstance(one, Estimate) else None for one in found]
        sigma = np.array([np.nan if one is None else one for one in known])
        product = np.outer(sigma, sigma)
        return replace(
            self.correlation,
            values=np.where(product == 0.0, 0.0, self.correlation.values * product),
        )

    def value(self, name: str) -> float:
        """A parameter's value; the first recording's where each has its own. KeyError if none."""
        found = self.parameters[name]
        return found.value if isinstance(found, Estimate) else found[0].value


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """One effect tried alone on the linear model; ``evidence`` is its gain in log-likelihood.

    ``at_bounds`` are the parameters of the linear core, and effects, that this drives to a bound of
    their range: then the effect is not accepted.
    """

    effect: str
    validation_rmse_deg: float
    held_out_rmse_deg: float
    evidence: float
    confounded_with: tuple[str, ...]
    at_bounds: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Diagnosis(Result):
    """What is missing, how sure that is, where the linear model fails and what adding gains.

    ``floor_deg`` is the smallest error that counts: hypot(``noise_deg``, ``tolerance_deg``), with
    ``scatter_deg`` in the place of the noise where runs with the same command differ by more.
    ``findings`` describe the error of the first model, the linear one unless more is ``known``
    before, ``remaining`` that of the last one.
    ``regimes`` are where validation and test data go beyond the fitted ones, with the share of the
    last model's squared error that is there. ``stability`` is the share of the ``resamples``, parts
    of the data, that name each effect: those of ``effects``, and others that are named in some.
    ``repeated`` says how much of the last model's error repeats where the command does,
    ``unexplained`` how much is left of it, what that depends on, and what to record next.
    ``detectable`` has the smallest size of each further effect that the fitted data would show.
    ``equivalents`` are other sets of effects whose models do as well as the last one, as far as the
    scatter of the errors from second to second tells; ``one_of`` has each effect of the last model
    that not all of these have, with what they have in its place: it is not in ``effects``.
    ``alternatives`` predict the same.
    ``transmissions`` have ratio and play between horn and surface, where both were measured.
    ``fmu`` is the file of the FMU that was diagnosed in the place of the linear model: k then
    multiplies its angle, and T and xi describe its own answer.

    >>> import numpy as np
    >>> import servosight as ss
    >>> from servosight.models.core import Estimate
    >>> time_s = np.arange(0.0, 5.0, 0.02)
    >>> command_deg = 10.0 * np.sign(np.sin(4.0 * time_s + 0.1))
    >>> core = {"k": 1.0, "T": 0.03, "xi": 0.6, "bias": 0.0}
    >>> act = ss.Actuator({name: Estimate(value, None, "") for name, value in core.items()})
    >>> angle_deg = act.predict(time_s=time_s, command_deg=command_deg)
    >>> angle_deg += 0.02 * np.random.default_rng(1).standard_normal(time_s.size)
    >>> why = ss.diagnose(
    ...     ss.Recording.from_arrays(time_s=time_s, angle_deg=angle_deg, command_deg=command_deg)
    ... )
    >>> why.verdict.value, why.effects, len(why.ladder)
    ('no_effect_missing', (), 1)
    >>> why.save("diagnosis.json")
    >>> ss.load("diagnosis.json").headline
    'No effect is missing'
    """

    TYPE: ClassVar[str] = "diagnosis"

    noise_deg: float
    tolerance_deg: float
    floor_deg: float
    verdict: Verdict
    headline: str
    summary: str
    effects: tuple[str, ...]
    ladder: Table[LadderStep]
    candidates: Table[Candidate]
    where: Table[Window]
    findings: Table[Finding]
    remaining: Table[Finding]
    alternatives: tuple[tuple[str, ...], ...]
    next_experiment: str
    proposal: Proposal | None
    law: Law | None
    recordings: Table[RecordingUse]
    warnings: tuple[str, ...]
    seconds: float
    regimes: Table[Regime] = field(default_factory=Table)
    known: PriorKnowledge = field(default_factory=PriorKnowledge)
    stability: Mapping[str, float] = field(default_factory=dict)
    resamples: int = 0
    repeated: Repeated | None = None
    unexplained: Unexplained | None = None
    detectable: Table[Detectable] = field(default_factory=Table)
    scatter_deg: float | None = None
    equivalents: tuple[tuple[str, ...], ...] = ()
    one_of: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    fmu: str | None = None
    transmissions: Table[Transmission] = field(default_factory=Table)

    @property
    def actuator(self) -> Actuator:
        """The last model of the ladder. InputError where it is an FMU, which no card can hold."""
        if self.fmu is not None:
            raise InputError(
                f"{self.fmu}: this diagnosis is of an FMU, expected one of the linear model; a "
                f"card cannot hold what is inside an FMU"
            )
        last = self.ladder[-1]
        kept = last.covariance
        bias = last.parameters["bias"]
        biases = bias if isinstance(bias, tuple) else (bias,)
        # The fitted ones come first, with a bias for each of their parts.
        before = itertools.accumulate((len(one.parts) for one in self.recordings), initial=0)
        parts = zip(self.recordings, before, strict=False)
        fitted_on = [one.name for one, earlier in parts if earlier < len(biases)]
        return Actuator(
            last.actuator.parameters,
            last.effects,
            {
                "fitted_on": fitted_on,
                "held_out_rmse_deg": last.held_out_rmse_deg,
                "method": "diagnose",
                **({} if kept is None else covariance_to_keep(kept.names, kept.values)),
            },
        )

    def report(
        self,
        path: Path | str,
        recordings: Any = None,
        *,
        catalogue: Mapping[str, Effect] | None = None,
    ) -> None:
        """Write a report to read in a browser.

        ``recordings`` are those of the diagnosis, or their paths (default: those given, or where
        they were); ``catalogue`` is needed where a diagnosis that was read back has effects of a
        plugin.
        """
        write_report(path, self, recordings, catalogue)

    def _paths(self) -> Sequence[Path | None]:
        return [one.path for one in self.recordings]

    def plot_ladder(self, ax: Axes | None = None) -> Axes:
        """Held-out error of each step on a logarithmic scale, and the floor."""
        steps = {
            f"{place}: {step.change}": step.held_out_rmse_deg
            for place, step in enumerate(self.ladder)
        }
        return plot_ladder(steps, self.floor_deg, ax)

    plot = plot_ladder
