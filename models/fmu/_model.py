"""An open FMU as a model of a servo: its input and output, and recordings run through it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array, InputError, Recording, did_you_mean, exposure_nodes
from servosight.models.fmu._fmu import Fmu, FmuVariable
from servosight.models.fmu._pieces import Pieces

COMMAND, ANGLE = "command", "angle"
OWN_NAMES = ("bias", "initial_angle", "initial_speed")
"""Parameters that belong to a recording and not to the servo, where an FMU has them."""
_RADIANS = ("rad", "radian", "radians")


@dataclass(frozen=True)
class FmuRun:
    """A recording as steps of an FMU, from time zero.

    ``time_s`` (steps + 1,), ``command_deg`` (steps,), ``nodes_s`` (samples *
    weights,) the instants of the exposures, ``weights`` (nodes,) their means.
    """

    recording: Recording
    time_s: Array
    command_deg: Array
    nodes_s: Array
    weights: Array


@dataclass(frozen=True)
class FmuModel:
    """An FMU with the names of its command and its angle, in their units."""

    fmu: Fmu
    command: FmuVariable
    angle: FmuVariable

    @classmethod
    def of(cls, fmu: Fmu, command: str | None = None, angle: str | None = None) -> FmuModel:
        """The input and output of those names; by default the only one, or one named so.

        Raises InputError that lists what there is.
        """
        return cls(
            fmu,
            _chosen(fmu, "input", command, COMMAND, "--fmu-input"),
            _chosen(fmu, "output", angle, ANGLE, "--fmu-output"),
        )

    @property
    def parameters(self) -> tuple[FmuVariable, ...]:
        """What may be fitted: parameters with a start value that belong to the servo."""
        return tuple(
            one
            for one in self.fmu.of("parameter")
            if one.start is not None
            and one.variability in ("tunable", "fixed")
            and one.name not in OWN_NAMES
        )

    @property
    def own(self) -> tuple[FmuVariable, ...]:
        """Those of ``OWN_NAMES`` that it has."""
        return tuple(one for one in self.fmu.of("parameter") if one.name in OWN_NAMES)

    def run_of(self, recording: Recording) -> FmuRun:
        """Steps that end at each row of the command and at each sample.

        An FMU that takes one step only takes that, under the command in its middle.
        """
        nodes, weights = exposure_nodes(recording.time_s, recording.exposure_s)
        pieces = Pieces.of(
            recording.command_time_s, recording.command_deg, recording.hold == "linear"
        )
        time_s, command = pieces.steps(nodes, self.fmu.step_s)
        return FmuRun(recording, time_s - nodes[0], command, nodes - nodes[0], weights)

    def angles(
        self, time_s: Array, command_deg: Array, names: Sequence[str], rows: Array
    ) -> tuple[Array, list[str]]:
        """Angles [deg] at the ends of the steps ``time_s`` (steps + 1,) from zero, and errors.

        ``command_deg`` (steps,), ``rows`` (runs, names) of parameters; returns (runs, steps + 1),
        NaN and a sentence where a run failed.
        """
        found, errors = self.fmu.run_rows(
            time_s,
            command_deg * _per_degree(self.command),
            names,
            rows,
            self.command.name,
            self.angle.name,
        )
        return np.stack(found) / _per_degree(self.angle), errors

    def predict(self, run: FmuRun, names: Sequence[str], rows: Array) -> tuple[Array, list[str]]:
        """Angles [deg] for ``rows`` (runs, names) of parameters: (runs, samples), and errors.

        NaN and a sentence where a run failed.
        """
        found, errors = self.angles(run.time_s, run.command_deg, names, rows)
        angles = np.stack([np.interp(run.nodes_s, run.time_s, one) for one in found])
        return angles.reshape(len(found), -1, run.weights.size) @ run.weights, errors


def _chosen(
    fmu: Fmu, causality: str, asked: str | None, usual: str, option: str
) -> FmuVariable:  # fmt: skip
    there = {one.name: one for one in fmu.of(causality)}
    for name in (asked,) if asked is not None else (usual, *there):
        if name in there and (asked is not None or name == usual or len(there) == 1):
            return there[name]
    if not there:
        raise InputError(
            f"{fmu.path}: has no {causality} that is a real number, expected one for the {usual}; "
            f"what takes no command or shows no angle is no model of a servo"
        )
    names = ", ".join(list(there)[:8])
    if asked is not None:
        raise InputError(
            f"{fmu.path}: has no {causality} {asked}{did_you_mean(asked, there)}; expected one of "
            f"{names}, so give {option} one of these"
        )
    raise InputError(
        f"{fmu.path}: has the {causality}s {names}, expected a single one or one named {usual}; "
        f"choose with {option} NAME"
    )


def _per_degree(variable: FmuVariable) -> float:
    """Units of a variable for each degree; what has no unit is taken for degrees."""
    return math.pi / 180.0 if variable.unit in _RADIANS else 1.0
