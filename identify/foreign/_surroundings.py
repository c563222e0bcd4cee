"""An FMU as the plant: what is simulated is the FMU, with effects before and behind it.

The catalogue of these effects brings the plant along, so that all that takes a catalogue (fit,
selection, comparison, prediction, report) works with an FMU as it does with the plant equation.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np

from servosight.identify.fit import polish
from servosight.identify.foreign._own import trusted
from servosight.identify.foreign._runs import Interface, Runs
from servosight.identify.problem import Problem, linear_start
from servosight.models.core import (
    Actuator,
    Estimate,
    InputError,
    Recording,
    did_you_mean,
    one_or_more,
)
from servosight.models.effects import Effect, Place
from servosight.models.fmu import Fmu, FmuModel
from servosight.models.plant import Plant, Stimulus

AROUND = (Place.COMMAND, Place.TRANSMISSION, Place.FEEDBACK)
"""Where an effect can act that needs nothing of what is inside an FMU; a sensor there is the one
that the recording is of."""


LINEAR, FMU = "linear", "FMU"
"""What effects act on, by name."""


class Surroundings(dict[str, Effect]):
    """The effects that can act around an FMU, by identifier, and the ``plant`` with the FMU in it.

    ``inside`` names those of the catalogue that cannot, ``actuator`` stands for the FMU.
    """

    def __init__(self, catalogue: Mapping[str, Effect], interface: Interface) -> None:
        super().__init__({n: one for n, one in catalogue.items() if one.place in AROUND})
        self.inside = tuple(name for name in catalogue if name not in self)
        self.actuator: Actuator | None = None
        self.runs = Runs(interface, tuple(self.values()))

    @property
    def plant(self) -> Plant:
        """What ``Plant.of`` returns for this catalogue."""
        return replace(self.runs.around, run=self.runs.fill, restartable=False)


@dataclass(frozen=True)
class Surrounded:
    """An open FMU as a model: ``catalogue`` and ``actuator`` stand for it where a model is taken.

    The actuator's k multiplies the FMU's angle; T and xi describe the FMU's own answer as a linear
    model and change nothing. ``around`` are held parameters of the effects; ``rest_deg`` is where
    the FMU rests under the first command.
    """

    catalogue: Surroundings
    actuator: Actuator
    model: FmuModel
    around: Mapping[str, float]
    rest_deg: float

    @property
    def held(self) -> dict[str, float]:
        """The parameters that describe, and are not to be fitted."""
        return {name: self.actuator.value(name) for name in ("T", "xi")}


@contextmanager
def surrounded(
    interface: Interface,
    catalogue: Mapping[str, Effect],
    recordings: Sequence[Recording],
    *,
    fix: Mapping[str, float] | None = None,
    trust: bool = False,
) -> Iterator[Surrounded]:
    """The FMU, running, with the effects of ``catalogue`` that can act around it.

    ``fix`` sets parameters of the FMU; k, where the FMU has none of that name, and parameters of
    the effects around it are ``around``. Raises InputError where ``trust`` is not given, for a
    value of a parameter that it does not have, and where it does not run on the first of the
    ``recordings``. Behind the context, the FMU is started again for whatever asks for a run.
    """
    trusted(interface.path, trust)
    first, *_ = one_or_more(recordings)
    around = Surroundings(catalogue, interface)
    with around.runs.opened() as model:
        given = dict(fix or {})
        outside = {name for name in given if name == "k" or name.partition(".")[0] in around}
        outside -= {one.name for one in model.parameters}
        values = {name: value for name, value in given.items() if name not in outside}
        _check_values(model, values)
        around.runs.values.update(values)
        around.actuator, (k, bias) = _described(around, model, first)
        rest_deg = k * float(first.command_deg[0]) + bias
        kept = {name: given[name] for name in outside}
        yield Surrounded(around, around.actuator, model, kept, rest_deg)


def _described(
    around: Surroundings, model: FmuModel, recording: Recording
) -> tuple[Actuator, tuple[float, float]]:
    """k = 1, the FMU's own bias, and T and xi of the linear model nearest to its answer.

    And that model's k and bias, which say where the FMU rests.
    """
    plant = around.plant
    row = np.array(plant.layout.neutral_row())
    bias = next((one.start or 0.0 for one in model.own if one.name == "bias"), 0.0)
    row[3], row[4] = bias, bias + recording.command_at(recording.time_s[:1])[0]
    angle = plant.simulate(row, Stimulus.of(recording))
    if not np.all(np.isfinite(angle)):
        raise _not_running(model.fmu, recording)
    own = replace(recording, angle_deg=angle, sigma_deg=None, shared_deg=None)
    problem = Problem.of([own], {}, ())
    point = polish(problem, [linear_start(problem)]).outcome.point
    values = problem.values(point)
    described = {"k": 1.0, "T": values["T"], "xi": values["xi"], "bias": bias}
    units = {"T": "s", "bias": "deg"}
    actuator = Actuator(
        {name: Estimate(v, None, units.get(name, "-")) for name, v in described.items()}, ()
    )
    return actuator, (values["k"], float(point[problem.physical]))


def base_of(catalogue: Mapping[str, Effect]) -> str:
    """What the effects of a catalogue act on."""
    return FMU if is_around_fmu(catalogue) else LINEAR


def is_around_fmu(catalogue: Mapping[str, Effect]) -> bool:
    """True for a catalogue of effects around an FMU."""
    return isinstance(catalogue, Surroundings)


def fmu_actuator(catalogue: Mapping[str, Effect]) -> Actuator | None:
    """What stands for the FMU in whose surroundings the effects act; None for other catalogues."""
    return catalogue.actuator if isinstance(catalogue, Surroundings) else None


def check_outside(names: Sequence[str], around: Surroundings) -> None:
    """Raise InputError for an effect that acts inside the FMU."""
    for name in names:
        if name in around.inside:
            raise InputError(
                f"{name} acts inside the position loop, which an FMU does not show, expected an "
                f"effect around it: {', '.join(around)}"
            )


def _not_running(fmu: Fmu, recording: Recording) -> InputError:
    return InputError(
        f"{fmu.path}: does not run on {recording.name}, expected an FMU that does; try it in the "
        f"tool it is of"
    )


def _check_values(model: FmuModel, values: Mapping[str, float]) -> None:
    known = {one.name: one for one in model.parameters}
    for name, value in values.items():
        if name not in known:
            raise InputError(
                f"{model.fmu.path}: has no parameter {name}{did_you_mean(name, known)}; expected "
                f"some of {', '.join(list(known)[:12]) or 'none'}"
            )
        if not known[name].low <= value <= known[name].high:
            raise InputError(
                f"{model.fmu.path}: {name} is {value:g}, expected {known[name].low:g} to "
                f"{known[name].high:g} {known[name].unit}"
            )
