"""An FMU and effects around it as one model, whose parameters are fitted jointly."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from servosight.identify.foreign._own import first_guess
from servosight.identify.foreign._runs import Interface
from servosight.identify.foreign._surroundings import (
    Surrounded,
    Surroundings,
    check_outside,
    surrounded,
)
from servosight.identify.problem import BaseModel, Problem
from servosight.models.core import OWN, Array, InputError, Parameter, Recording, either
from servosight.models.effects import Effect
from servosight.models.fmu import Fmu, FmuModel, FmuRun, FmuVariable
from servosight.models.plant import Stimulus

_BIAS = next(q for q in OWN if q.name == "bias")
_MOST_GUESSES = 27
_FAILED = "with effects around it, its run failed"


@dataclass(frozen=True)
class EffectsAround:
    """An FMU with ``effects`` around it, in the place of the FMU alone.

    ``own`` are the numbers of each recording: its bias, and those that the FMU has parameters for.
    """

    around: Surroundings
    inner: FmuModel
    effects: tuple[Effect, ...]

    @property
    def fmu(self) -> Fmu:
        """The open FMU."""
        return self.inner.fmu

    @property
    def own(self) -> tuple[FmuVariable, ...]:
        """The bias, which an FMU need not have for this, then its initial angle and speed."""
        there = {one.name: one for one in self.inner.own}
        return (there.pop("bias", _variable(_BIAS)), *there.values())

    @property
    def variables(self) -> tuple[FmuVariable, ...]:
        """The effects' parameters, by names such as backlash.gap."""
        return tuple(
            _variable(q, f"{effect.id}.") for effect in self.effects for q in effect.parameters
        )

    @property
    def parameters(self) -> tuple[FmuVariable, ...]:
        """The FMU's, then those of the effects."""
        return (*self.inner.parameters, *self.variables)

    def run_of(self, recording: Recording) -> FmuRun:
        """The recording as steps of the FMU."""
        return self.inner.run_of(recording)

    def predict(self, run: FmuRun, names: Sequence[str], rows: Array) -> tuple[Array, list[str]]:
        """Angles [deg] for ``rows`` (runs, names) of parameters: (runs, samples), and errors."""
        plant, runs = self.around.plant, self.around.runs
        stimulus, columns = Stimulus.of(run.recording), plant.layout.names()
        given = {one.name for one in self.inner.parameters}
        angles = []
        for values in rows:
            row = np.array(plant.layout.neutral_row())
            row[columns.index("initial_angle")] = run.recording.angle_deg[0]
            runs.values = {}
            for name, value in zip(names, values.tolist(), strict=True):
                if name in given:
                    runs.values[name] = value
                else:
                    row[columns.index(name)] = value
            angles.append(plant.simulate(row, stimulus))
        errors = ["" if np.all(np.isfinite(one)) else _FAILED for one in angles]
        return np.stack(angles), errors

    def guesses(self, recordings: Sequence[Recording]) -> list[dict[str, float]]:
        """Initial guesses of the effects' parameters, from what the FMU alone leaves."""
        actuator = self.around.actuator
        assert actuator is not None
        core = {name: actuator.value(name) for name in ("k", "T", "xi")}
        problem = Problem.of(recordings, self.around, (), held=core)
        point = [core["k"], math.log(core["T"]), math.log(core["xi"])]
        for recording in recordings:
            start = dict(
                zip([one.name for one in self.own], first_guess(recording, self), strict=True)
            )
            own = {"initial_angle": recording.angle_deg[0], **start}
            point += [own.get(one.name, 0.0) for one in OWN]
        base = BaseModel(problem, np.array(point))
        combinations = itertools.product(*(base.guesses(effect) for effect in self.effects))
        return [
            {
                f"{effect.id}.{q.name}": value
                for effect, values in zip(self.effects, starts, strict=True)
                for q, value in zip(effect.parameters, values, strict=True)
            }
            for starts in itertools.islice(combinations, _MOST_GUESSES)
        ]


@contextmanager
def effects_around(
    interface: Interface,
    catalogue: Mapping[str, Effect],
    effects: Sequence[str],
    recordings: Sequence[Recording],
    *,
    trust: bool,
) -> Iterator[EffectsAround]:
    """The FMU, running, with ``effects`` around it; InputError for one that cannot be there."""
    with surrounded(interface, catalogue, recordings, trust=trust) as model:
        check_outside(effects, model.catalogue)
        model.catalogue.runs.exact = True
        found = EffectsAround(
            model.catalogue, model.model, tuple(catalogue[name] for name in effects)
        )
        _check_names(model, found)
        yield found


def _variable(q: Parameter, prefix: str = "") -> FmuVariable:
    return FmuVariable(
        name=f"{prefix}{q.name}",
        causality="parameter",
        variability="tunable",
        start=q.neutral,
        low=q.low,
        high=q.high,
        unit=q.unit,
    )


def _check_names(model: Surrounded, found: EffectsAround) -> None:
    own = {one.name for one in model.model.parameters}
    for name in (one.name for one in found.variables):
        if name in own:
            raise InputError(
                f"{found.fmu.path}: has a parameter {name} itself, expected effects that it lacks; "
                f"fit that one by {either('parameters', '--parameters')}"
            )
