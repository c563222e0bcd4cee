"""Runs of an FMU as those of a plant: one for each shape of the command, the rest added behind.

An FMU takes far longer for a run than the compiled plant. What a search changes most, the bias and
what acts behind the output, needs no new run; the initial state adds its share to first order.
"""

from __future__ import annotations

import hashlib
from collections import OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from servosight.identify.foreign._behind import measured, with_turns
from servosight.models.core import Array
from servosight.models.effects import Effect, Place
from servosight.models.fmu import FmuModel, FmuVariable, Pieces, open_fmu
from servosight.models.plant import Layout, Plant, Stimulus

_LONGEST_S = 5e-3
"""Steps are no longer: where the motion turns round, play must see how far it went."""
_LEAST_K = 0.1
"""A smaller factor says nothing of the motor: its first angle and speed are then not divided."""
_REST_S, _REST_STEP_S = 10.0, 0.02
"""How long an FMU is given to come to rest under the first command."""
_KEPT = 512
"""Runs of an FMU that are kept."""
_STATE = {"initial_angle": (4, 4.0, 0.5), "initial_speed": (5, 400.0, 20.0)}
"""Of the initial state: its column in a row, about which multiples a run is extended to first
order [deg], [deg/s], and the step of the difference quotient."""


@dataclass(frozen=True)
class Interface:
    """The FMU's file, and the names of its input and output."""

    path: Path
    command: str | None = None
    angle: str | None = None


@dataclass(frozen=True)
class _Asked:
    """A command and the instants at which the output is wanted."""

    stimulus: Stimulus
    digest: bytes

    @classmethod
    def of(cls, times: Array, values: Array, linear: bool, samples: Array) -> _Asked:
        text = b"".join([times.tobytes(), values.tobytes(), samples.tobytes(), bytes([linear])])
        digest = hashlib.blake2b(text, digest_size=16).digest()
        return cls(Stimulus(times, values, linear, samples, np.ones(1)), digest)

    @property
    def samples_s(self) -> Array:
        """The instants, (samples,)."""
        return self.stimulus.samples_s


@dataclass(frozen=True)
class _Answer:
    """Angles of the FMU [deg] at instants: (instants,), or (runs, instants)."""

    time_s: Array
    angle_deg: Array


class Runs:
    """What an FMU answers, kept by command, initial state and ``values`` of its parameters.

    Where those values change from run to run, ``exact`` runs it from the initial state itself.
    """

    def __init__(self, interface: Interface, effects: tuple[Effect, ...]) -> None:
        self.interface = interface
        self.layout = Layout.of(effects)
        self.around = Plant.of({one.id: one for one in effects})
        self.values: dict[str, float] = {}
        self.model: FmuModel | None = None
        self.own: tuple[FmuVariable, ...] = ()
        self.exact = False
        self.kept: OrderedDict[tuple[bytes, ...], _Answer | None] = OrderedDict()

    @contextmanager
    def opened(self) -> Iterator[FmuModel]:
        """The FMU in its process: the one that runs already, or one for now."""
        if self.model is not None:
            yield self.model
            return
        asked = self.interface
        with open_fmu(asked.path) as fmu:
            self.model = FmuModel.of(fmu, asked.command, asked.angle)
            self.own = self.model.own
            try:
                yield self.model
            finally:
                self.model = None

    # The signature is that of the compiled kernel, which this stands in for.
    def fill(
        self, rows: Array, times: Array, values: Array, linear: bool, joined_deg: float,
        pushes: Array, restarts: Array, samples: Array, horn: bool, step: float, out: Array,
    ) -> None:  # fmt: skip
        """Simulate ``rows`` (batch, parameters) into ``out`` (batch, samples), NaN where it fails.

        The steps are the FMU's own and its one input is the command: ``step``, ``joined_deg``,
        ``pushes`` and ``restarts`` are not used.
        """
        asked = _Asked.of(times, values, linear, samples)
        for row, target in zip(rows, out, strict=True):
            target[:] = self._angle(row, asked, horn)
        # What was asked for first is given up first.
        while len(self.kept) > _KEPT:
            self.kept.popitem(last=False)

    def _angle(self, row: Array, asked: _Asked, horn: bool) -> Array:
        """The angle at the samples: the FMU's, scaled, shifted, and behind linkage and sensor."""
        zero = next((one.start or 0.0 for one in self.own if one.name == "bias"), 0.0)
        k, bias = row[0], row[3]
        names = [one.name for one in self.own if one.name in _STATE]
        scale = k if abs(k) > _LEAST_K else 1.0
        first = {"initial_angle": self._first_angle(row, asked, zero) - bias}
        state = np.array([first.get(name, row[_STATE[name][0]]) / scale for name in names])
        state[[name == "initial_angle" for name in names]] += zero
        about = np.array([_STATE[name][1] for name in names])
        about = state if self.exact else about * np.round(state / about)
        found = self._answer(row, asked, names, about)
        if found is None:
            return np.full(asked.samples_s.size, np.nan)
        angle = found.angle_deg
        free = self._free(asked, names, about) if np.any(state != about) else None
        if free is not None:
            for change, slope in zip(state - about, free.angle_deg, strict=True):
                angle = angle + change * np.interp(found.time_s, free.time_s, slope)
        time_s, angle = with_turns(found.time_s, k * (angle - zero) + bias)
        if not horn:
            angle = self.around.behind_transmission(row, angle)
            angle = measured(self._values(row, Place.FEEDBACK), angle)
        return np.asarray(np.interp(asked.samples_s, time_s, angle))

    def _first_angle(self, row: Array, asked: _Asked, zero: float) -> float:
        """Where the motor is at first [deg], seen through the surface: as the plant kernel has it.

        Within its play the surface says nothing of the motor, which then is where the command holds
        it, or as near to it as it can be without moving the surface.
        """
        seen = float(row[4])
        if not any(self._active(row, Place.TRANSMISSION)):
            return seen
        rest = self._rest(row, asked)
        if rest is None:
            return seen
        at = np.array([row[0] * (rest - zero) + row[3]])
        apart = row.copy()
        apart[4] = at[0]
        free = self.around.behind_transmission(apart, at)
        return seen + float((free - self.around.behind_transmission(row, at))[0])

    def _rest(self, row: Array, asked: _Asked) -> float | None:
        """Where the FMU comes to rest under the first command; None where it fails."""
        pieces = self._pieces(row, asked)
        if pieces is None:
            return None
        first = pieces.at(asked.samples_s[:1])
        key = (b"rest", first.tobytes(), self._digits())
        if key not in self.kept:
            held = Pieces(np.zeros(1), first, np.zeros(1))
            runs = self._stepped(held, np.array([0.0, _REST_S]), _REST_STEP_S, [], np.empty((1, 0)))
            self.kept[key] = runs
        found = self.kept[key]
        return None if found is None else float(found.angle_deg[0, -1])

    def _answer(self, row: Array, asked: _Asked, names: list[str], state: Array) -> _Answer | None:
        """The FMU under the row's command from an initial state; None where it fails."""
        values = [own for _, own in self._values(row, Place.COMMAND)]
        key = (asked.digest, np.array([*sum(values, ()), *state]).tobytes(), self._digits())
        if key not in self.kept:
            runs = self._run(row, asked, names, state[None, :])
            self.kept[key] = None if runs is None else _Answer(runs.time_s, runs.angle_deg[0])
        return self.kept[key]

    def _free(self, asked: _Asked, names: list[str], state: Array) -> _Answer | None:
        """Change of the angle with each number of the initial state, under the command as given."""
        key = (asked.digest, b"free", state.tobytes(), self._digits())
        if key not in self.kept:
            steps = np.array([_STATE[name][2] for name in names])
            neutral = np.array(self.layout.neutral_row())
            table = np.vstack([state, state + np.diag(steps)])
            runs = self._run(neutral, asked, names, table)
            if runs is not None:
                slopes = (runs.angle_deg[1:] - runs.angle_deg[0]) / steps[:, None]
                runs = _Answer(runs.time_s, slopes)
            self.kept[key] = runs
        return self.kept[key]

    def _run(self, row: Array, asked: _Asked, names: list[str], states: Array) -> _Answer | None:
        """The FMU from each of some initial states (runs, names); None where one run fails."""
        pieces = self._pieces(row, asked)
        if pieces is None:
            return None
        return self._stepped(pieces, asked.samples_s, _LONGEST_S, names, states)

    def _pieces(self, row: Array, asked: _Asked) -> Pieces | None:
        """The command behind the effects on it; None where their pieces run out."""
        shaped = self.around.shaped_command(row, asked.stimulus)
        return Pieces(*shaped.T) if np.all(np.isfinite(shaped)) else None

    def _stepped(
        self, pieces: Pieces, samples_s: Array, longest_s: float, names: list[str], states: Array
    ) -> _Answer | None:
        fixed = self.values
        table = np.hstack([states, np.tile([*fixed.values()], (len(states), 1))])
        with self.opened() as model:
            time_s, command = pieces.steps(samples_s, model.fmu.step_s, longest_s)
            angles, errors = model.angles(time_s - time_s[0], command, [*names, *fixed], table)
        return None if any(errors) else _Answer(time_s, angles)

    def _digits(self) -> bytes:
        """The parameters that are set, as part of a key."""
        return repr(self.values).encode()

    def _active(self, row: Array, place: Place) -> list[bool]:
        """Of the effects at a place, which have a parameter that is not neutral."""
        return [
            any(
                q.neutral is not None and value != q.neutral
                for q, value in zip(effect.parameters, values, strict=True)
            )
            for effect, values in self._values(row, place)
        ]

    def _values(self, row: Array, place: Place) -> list[tuple[Effect, tuple[float, ...]]]:
        """The effects at a place, each with the row's parameters of it."""
        layout = self.layout
        return [
            (effect, tuple(row[offset : offset + len(effect.parameters)].tolist()))
            for effect, offset in zip(layout.effects, layout.offsets, strict=True)
            if effect.place is place
        ]
