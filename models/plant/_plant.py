"""The one plant equation, compiled: parameters and a command in, the surface's angle out."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from servosight.models.core import Array, Recording, exposure_nodes
from servosight.models.effects import Effect
from servosight.models.plant.kernel import Layout, kernel, not_compiled

_MOST_PIECES = 1_000_000
Steps = NDArray[np.int64]


def _own_layout(values: Array) -> Array:
    """In the one layout in memory for which the kernel is compiled: another costs half a minute."""
    return np.require(values, np.float64, ("C_CONTIGUOUS", "WRITEABLE"))


@dataclass(frozen=True)
class Stimulus:
    """The command's rows and the instants at which the output is wanted.

    ``time_s`` (rows,) rising, ``command_deg`` (rows,), ``linear`` True where rows are joined by
    lines; ``samples_s`` (samples * nodes,) rising; ``weights`` (nodes,) average the nodes of one
    sample's exposure. ``horn`` True where the horn's angle is wanted: before shaft and linkage.
    ``disturbance`` (2, rows): times and values of the known disturbance, held between rows.
    ``restarts`` (3, n): times [s], angles [deg] and speeds [deg/s] with which the motion begins
    anew there, whatever the model has come to; none in a simulation from the command alone.
    ``joined_deg``: rows closer to each other than a step are taken as one straight line where that
    changes the motion by about so much [deg] at most, which is faster; 0: a step ends at each row.
    """

    time_s: Array
    command_deg: Array
    linear: bool
    samples_s: Array
    weights: Array
    horn: bool = False
    disturbance: Array = field(default_factory=lambda: np.zeros((2, 1)))
    restarts: Array = field(default_factory=lambda: np.zeros((3, 0)))
    joined_deg: float = 0.0

    def __post_init__(self) -> None:
        for name in ("time_s", "command_deg", "samples_s", "disturbance", "restarts"):
            object.__setattr__(self, name, _own_layout(getattr(self, name)))

    @cached_property
    def digest(self) -> bytes:
        """The same for stimuli that ask the same: a hash of all that they hold."""
        found = hashlib.blake2b(
            f"{self.linear} {self.horn} {self.joined_deg}".encode(), digest_size=16
        )
        for values in (
            self.time_s, self.command_deg, self.samples_s, self.weights,
            self.disturbance, self.restarts,
        ):  # fmt: skip
            found.update(str(values.shape).encode())
            found.update(values.tobytes())
        return found.digest()

    @property
    def duration_s(self) -> float:
        """From the first sample to the last."""
        return float(self.samples_s[-1] - self.samples_s[0])

    @classmethod
    def of(cls, recording: Recording) -> Stimulus:
        """What a recording asks of the plant."""
        samples, weights = exposure_nodes(recording.time_s, recording.exposure_s)
        return cls(
            recording.command_time_s,
            recording.command_deg,
            recording.hold == "linear",
            samples,
            weights,
            recording.side != "surface",
            recording.disturbance_rows,
        )


@dataclass(frozen=True)
class Plant:
    """The plant equation for a registry of effects, with the layout of its parameter rows."""

    layout: Layout
    run: Callable[..., Steps | None]
    shape: Callable[..., int]
    transmit: Callable[..., None]
    filter: Callable[..., None]
    restartable: bool = True
    """False where the motion cannot begin anew on the way, as that of an FMU."""

    @classmethod
    def of(cls, effects: Mapping[str, Effect]) -> Plant:
        """Compile the plant, or take the compiled one from the cache.

        A catalogue may bring a plant of its own, as ``plant``: that of effects around an FMU does.
        """
        own = getattr(effects, "plant", None)
        return own if isinstance(own, Plant) else _plant(tuple(effects.values()))

    def index(self, name: str) -> int:
        """Position of a parameter (``k`` or ``effect.parameter``) in a row."""
        return self.layout.names().index(name)

    def simulate(self, rows: Array, stimulus: Stimulus, step_s: float | None = None) -> Array:
        """Angles [deg] for a batch of rows.

        ``rows`` (batch, parameters) or (parameters,); returns (batch, samples) or (samples,).
        ``step_s`` bounds the step (default: a quarter of each row's T, or of its slow pole's). Rows
        whose steps run out give NaN.
        """
        return self.simulate_counted(rows, stimulus, step_s)[0]

    def simulate_counted(
        self, rows: Array, stimulus: Stimulus, step_s: float | None = None
    ) -> tuple[Array, Steps | None]:
        """The same, and what each row cost, in steps of the linear core, (batch,); None where the
        plant does not tell, as an FMU."""
        batch = np.atleast_2d(np.asarray(rows, dtype=np.float64))
        if batch.shape[1] != self.layout.width:
            raise ValueError(f"rows have {batch.shape[1]} columns, expected {self.layout.width}")
        out = np.empty((batch.shape[0], stimulus.samples_s.size))
        arguments = (
            np.ascontiguousarray(batch),
            stimulus.time_s,
            stimulus.command_deg,
            stimulus.linear,
            stimulus.joined_deg,
            stimulus.disturbance,
            stimulus.restarts,
            stimulus.samples_s,
            stimulus.horn,
            0.0 if step_s is None else step_s,
            out,
        )
        try:
            taken = self.run(*arguments)
        except Exception as error:  # at the first call, when it is compiled
            raise not_compiled(self.layout.effects, error) from error
        if stimulus.weights.size > 1:
            out = out.reshape(batch.shape[0], -1, stimulus.weights.size) @ stimulus.weights
        return (out if np.ndim(rows) == 2 else out[0]), taken

    def shaped_command(self, row: Array, stimulus: Stimulus) -> Array:
        """The command behind the effects on it, from the first sample to the last.

        ``row`` (parameters,); returns straight pieces (pieces, 3): start [s], value [deg], slope
        [deg/s]. NaN where the pieces run out.
        """
        first, last = float(stimulus.samples_s[0]), float(stimulus.samples_s[-1])
        out = np.empty((_MOST_PIECES, 3))
        asked = (stimulus.time_s, stimulus.command_deg, stimulus.linear, first, last, out)
        try:
            count = self.shape(np.ascontiguousarray(row), *asked)
        except Exception as error:  # as in simulate
            raise not_compiled(self.layout.effects, error) from error
        return np.full((1, 3), np.nan) if count < 0 else out[:count].copy()

    def behind_transmission(self, row: Array, angle_deg: Array) -> Array:
        """The surface's angle where that of the horn is given, instant by instant, (instants,)."""
        out = np.empty(angle_deg.size)
        try:
            self.transmit(np.ascontiguousarray(row), np.ascontiguousarray(angle_deg), out)
        except Exception as error:  # as in simulate
            raise not_compiled(self.layout.effects, error) from error
        return out

    def filtered(self, numerator: Array, denominator: Array, rows: Array) -> Array:
        """``rows`` (many, samples) behind a difference equation of second order, from rest.

        ``numerator`` and ``denominator`` (3,) are those of :func:`loop_filter`.
        """
        out = np.empty(rows.shape)
        self.filter(_own_layout(numerator), _own_layout(denominator), _own_layout(rows), out)
        return out


@functools.lru_cache(maxsize=8)
def _plant(effects: tuple[Effect, ...]) -> Plant:
    registry = {effect.id: effect for effect in effects}
    run, shape, transmit, filtering = kernel(registry)
    return Plant(Layout.of(effects), run, shape, transmit, filtering)
