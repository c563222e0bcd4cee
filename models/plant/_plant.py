"""The one plant equation, compiled: parameters and a command in, the surface's angle out."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array, Recording, exposure_nodes
from servosight.models.effects import Effect
from servosight.models.plant._codegen import kernel, not_compiled
from servosight.models.plant._layout import Layout


@dataclass(frozen=True)
class Stimulus:
    """The command's rows and the instants at which the output is wanted.

    ``time_s`` (rows,) rising, ``command_deg`` (rows,), ``linear`` True where rows are joined by
    lines; ``samples_s`` (samples * nodes,) rising; ``weights`` (nodes,) average the nodes of one
    sample's exposure. ``horn`` True where the horn's angle is wanted: before shaft and linkage.
    """

    time_s: Array
    command_deg: Array
    linear: bool
    samples_s: Array
    weights: Array
    horn: bool = False

    @classmethod
    def of(cls, recording: Recording) -> Stimulus:
        """What a recording asks of the plant."""
        samples, weights = exposure_nodes(recording.time_s, recording.exposure_s)
        return cls(
            np.ascontiguousarray(recording.command_time_s, dtype=np.float64),
            np.ascontiguousarray(recording.command_deg, dtype=np.float64),
            recording.hold == "linear",
            samples,
            weights,
            recording.side == "horn",
        )


@dataclass(frozen=True)
class Plant:
    """The plant equation for a registry of effects, with the layout of its parameter rows."""

    layout: Layout
    run: Callable[..., None]

    @classmethod
    def of(cls, effects: Mapping[str, Effect]) -> Plant:
        """Compile the plant, or take the compiled one from the cache."""
        return _plant(tuple(effects.values()))

    def index(self, name: str) -> int:
        """Position of a parameter (``k`` or ``effect.parameter``) in a row."""
        return self.layout.names().index(name)

    def simulate(self, rows: Array, stimulus: Stimulus, step_s: float | None = None) -> Array:
        """Angles [deg] for a batch of rows.

        ``rows`` (batch, parameters) or (parameters,); returns (batch, samples) or (samples,).
        ``step_s`` bounds the step (default: a fifth of each row's T, or of its slow pole's). Rows
        whose steps run out give NaN.
        """
        batch = np.atleast_2d(np.asarray(rows, dtype=np.float64))
        if batch.shape[1] != self.layout.width:
            raise ValueError(f"rows have {batch.shape[1]} columns, expected {self.layout.width}")
        out = np.empty((batch.shape[0], stimulus.samples_s.size))
        arguments = (
            np.ascontiguousarray(batch),
            stimulus.time_s,
            stimulus.command_deg,
            stimulus.linear,
            stimulus.samples_s,
            stimulus.horn,
            0.0 if step_s is None else step_s,
            out,
        )
        try:
            self.run(*arguments)
        except Exception as error:  # at the first call, when it is compiled
            raise not_compiled(self.layout.effects, error) from error
        if stimulus.weights.size > 1:
            out = out.reshape(batch.shape[0], -1, stimulus.weights.size) @ stimulus.weights
        return out if np.ndim(rows) == 2 else out[0]


@functools.lru_cache(maxsize=8)
def _plant(effects: tuple[Effect, ...]) -> Plant:
    registry = {effect.id: effect for effect in effects}
    return Plant(Layout.of(effects), kernel(registry))
