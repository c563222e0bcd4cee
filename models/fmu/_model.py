"""An open FMU as a model of a servo: its input and output, and recordings run through it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array, InputError, Recording, exposure_nodes
from servosight.models.fmu._fmu import Fmu, FmuVariable

COMMAND, ANGLE = "command", "angle"
OWN_NAMES = ("bias", "initial_angle", "initial_speed")
"""Parameters that belong to a recording and not to the servo, where an FMU has them."""
_LINE_STEP_S = 1e-3
_APART_S = 1e-9
_RADIANS = ("rad", "radian", "radians")


@dataclass(frozen=True)
class FmuRun:
    """A recording as steps of an FMU, from time zero.

    ``time_s`` (steps + 1,), ``command`` (steps,) in the input's unit, ``nodes_s`` (samples *
    weights,) the instants of the exposures, ``weights`` (nodes,) their means.
    """

    recording: Recording
    time_s: Array
    command: Array
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
            _chosen(fmu, "input", command, COMMAND, "--input"),
            _chosen(fmu, "output", angle, ANGLE, "--output"),
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
        first, last = float(nodes[0]), float(nodes[-1])
        rows = recording.command_time_s
        linear = recording.hold == "linear"
        if linear:
            rows = np.concatenate([rows, np.arange(first, last, _LINE_STEP_S)])
        time_s = np.unique(np.concatenate([rows[(rows > first) & (rows < last)], nodes]))
        time_s = time_s[np.concatenate([[True], np.diff(time_s) > _APART_S])]
        step_s = self.fmu.step_s
        if step_s is not None:
            time_s = np.arange(int(np.ceil((last - first) / step_s)) + 1) * step_s + first
        at = 0.5 * (time_s[1:] + time_s[:-1])
        command = recording.command_at(at)
        return FmuRun(
            recording,
            np.asarray(time_s - first),
            command * _per_degree(self.command),
            np.asarray(nodes) - first,
            weights,
        )

    def predict(self, run: FmuRun, names: Sequence[str], rows: Array) -> tuple[Array, list[str]]:
        """Angles [deg] for ``rows`` (runs, names) of parameters: (runs, samples), and errors.

        NaN and a sentence where a run failed.
        """
        found, errors = self.fmu.run_rows(
            run.time_s, run.command, names, rows, self.command.name, self.angle.name
        )
        angles = np.stack([np.interp(run.nodes_s, run.time_s, one) for one in found])
        angles = angles.reshape(len(found), -1, run.weights.size) @ run.weights
        return angles / _per_degree(self.angle), errors


def _chosen(
    fmu: Fmu, causality: str, asked: str | None, usual: str, option: str
) -> FmuVariable:  # fmt: skip
    there = {one.name: one for one in fmu.of(causality)}
    for name in (asked,) if asked is not None else (usual, *there):
        if name in there and (asked is not None or name == usual or len(there) == 1):
            return there[name]
    names = ", ".join(list(there)[:8]) or "none"
    wanted = (
        f"one named {usual}, or its name behind {option}" if asked is None else f"a {causality}"
    )
    raise InputError(
        f"{fmu.path}: has the {causality}s {names}"
        + (f", but none {asked}" if asked is not None else "")
        + f"; expected {wanted}, so give {option} NAME"
    )


def _per_degree(variable: FmuVariable) -> float:
    """Units of a variable for each degree; what has no unit is taken for degrees."""
    return math.pi / 180.0 if variable.unit in _RADIANS else 1.0
