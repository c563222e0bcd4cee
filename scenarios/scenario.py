"""A declared experiment: everything that makes a synthetic recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from msgspec import Meta

from servosight.models import excitation as shapes
from servosight.models.core import (
    APART,
    DISTURBANCE,
    Array,
    Camera,
    InputError,
    Signals,
    read_settings,
    validated,
    validated_value,
    within,
)
from servosight.models.effects import catalogue
from servosight.models.excitation import Excitation
from servosight.scenarios.camera_settings import TABLES, read_filming
from servosight.scenarios.limits import LARGEST_DEG, check_scenario
from servosight.sim.bench import SHORTEST_T_S, BenchParameters
from servosight.sim.effects import resolve
from servosight.sim.film import VideoSettings

_TABLES = Meta(
    description="one table for each effect",
    extra={"fix": "write [effects.backlash] and below it gap = 2.0"},
)
Effects = Annotated[Mapping[str, Annotated[Mapping[str, float], _TABLES]], _TABLES]


@dataclass(frozen=True)
class LinearServo:
    """The true linear servo: gain k [-], T [s], xi [-], and the angle at zero command [deg]."""

    k: Annotated[float, within(-100.0, 100.0, "and not 0")] = 1.0
    T: Annotated[float, within(SHORTEST_T_S, 2.0, "seconds")] = 0.02
    xi: Annotated[float, within(0.02, 20.0, "as a ratio")] = 0.6
    bias: Annotated[float, within(-LARGEST_DEG, LARGEST_DEG, "degrees")] = 0.0

    def bench(self) -> BenchParameters:
        """A test bench with this transfer function."""
        return BenchParameters.with_response(self.k, self.T, self.xi, self.bias)


@dataclass(frozen=True)
class CommandSettings:
    """The command: a ``kind`` of ``limits.KINDS``, in rows at ``rate_hz``.

    ``dwell_s`` is for steps, ``frequency_hz`` for sine and triangle, ``low_hz`` and ``high_hz``
    for chirp and multisine.
    """

    kind: str = "standard"
    amplitude_deg: Annotated[float, within(-LARGEST_DEG, LARGEST_DEG, "degrees")] = 20.0
    rate_hz: Annotated[float, within(1.0, 1e4, "Hz")] = 250.0
    dwell_s: Annotated[float, within(1e-3, 600.0, "seconds")] = 0.8
    frequency_hz: Annotated[float, within(1e-3, 5e3, "Hz")] = 1.0
    low_hz: Annotated[float, within(1e-3, 5e3, "Hz and less than high_hz")] = 0.5
    high_hz: Annotated[float, within(1e-3, 5e3, "Hz and more than low_hz")] = 9.0


@dataclass(frozen=True)
class DisturbanceSettings:
    """Pulses of a known disturbance for effects that need one, up and down in turn."""

    amplitude: Annotated[float, within(-1e6, 1e6, "in its unit")] = 20.0
    period_s: Annotated[float, within(1e-2, 600.0, "seconds")] = 1.7
    width_s: Annotated[float, within(1e-3, 600.0, "seconds and less than period_s")] = 0.4
    unit: str = "N"

    def signals(self, duration_s: float) -> Signals:
        """The rows at which it changes."""
        starts = np.arange(0.5 * self.period_s, duration_s, self.period_s)
        sizes = np.where(np.arange(starts.size) % 2 == 0, self.amplitude, -self.amplitude)
        width = min(self.width_s, 0.999 * self.period_s)
        time_s = np.concatenate([[0.0], np.stack([starts, starts + width], axis=1).ravel()])
        values = np.concatenate([[0.0], np.stack([sizes, 0.0 * sizes], axis=1).ravel()])
        return Signals(time_s, {f"{DISTURBANCE}{self.unit}": values})


CommandFunction = Callable[[Array, CommandSettings, int], Array]

_SHAPES: Mapping[str, CommandFunction] = {
    "steps": lambda t, m, seed: shapes.steps(t, m.amplitude_deg, m.dwell_s, seed),
    "chirp": lambda t, m, seed: shapes.chirp(t, m.amplitude_deg, m.low_hz, m.high_hz),
    "triangle": lambda t, m, seed: shapes.triangle(t, m.amplitude_deg, m.frequency_hz),
    "sine": lambda t, m, seed: shapes.sine(t, m.amplitude_deg, m.frequency_hz),
    "multisine": lambda t, m, seed: shapes.multisine(t, m.amplitude_deg, m.low_hz, m.high_hz, seed),
}


@dataclass(frozen=True)
class Scenario:
    """Servo, hidden effects, command, camera and noise, all seeded.

    ``effects`` maps identifiers to parameters; what is left out takes the twin's default.
    ``noise_deg`` is added to the angles where there is no ``video``; with one, the noise is the
    picture's.
    """

    seed: Annotated[int, Meta(ge=0, description="a whole number from 0")] = 0
    duration_s: Annotated[float, within(1.0, 600.0, "seconds")] = 20.0
    noise_deg: Annotated[float, within(0.0, 90.0, "degrees")] = 0.03
    video: bool = False
    servo: LinearServo = field(default_factory=LinearServo)
    motion: CommandSettings = field(default_factory=CommandSettings)
    camera: Camera = field(default_factory=Camera)
    filming: Annotated[VideoSettings, APART] = field(default_factory=VideoSettings)
    effects: Effects = field(default_factory=dict)
    disturbance: DisturbanceSettings = field(default_factory=DisturbanceSettings)

    @classmethod
    def load(cls, path: Path) -> Scenario:
        """Read a scenario; InputError names the file, the key and what was expected.

        Keys are the fields' names; ``[servo]``, ``[motion]``, ``[camera]``, those of
        docs/camera.md and ``[effects.ID]`` are tables.
        """
        table = read_settings(path, "a scenario in TOML, with lines such as duration_s = 20.0")
        return cls.of(table, str(path))

    @classmethod
    def of(cls, table: Mapping[str, Any], source: str) -> Scenario:
        """The scenario with the keys of ``table``; InputError names ``source`` and the key."""
        scenario = replace(
            validated(table, cls, source, others=TABLES), filming=read_filming(table, source)
        )
        check_scenario(scenario, source)
        return scenario

    def excitation(self) -> Excitation:
        """The command's rows, and the known disturbance where an effect needs one."""
        rows = self._command()
        known = catalogue()
        if not any(known[name].needs_disturbance for name in self.effects if name in known):
            return rows
        return replace(rows, disturbance=self.disturbance.signals(self.duration_s))

    def _command(self) -> Excitation:
        motion = self.motion
        if motion.kind == "standard":
            return shapes.standard(self.duration_s, motion.amplitude_deg, self.seed, motion.rate_hz)
        time_s = np.arange(round(self.duration_s * motion.rate_hz) + 1) / motion.rate_hz
        return Excitation(time_s, _SHAPES[motion.kind](time_s, motion, self.seed))

    def truth(self) -> dict[str, float]:
        """All true parameters by the names that a model card uses."""
        return {
            **asdict(self.servo),
            **{
                f"{effect}.{name}": value
                for effect, values in resolve(self.effects).items()
                for name, value in values.items()
            },
        }


def with_effects(scenario: Scenario, ids: Sequence[str], settings: Mapping[str, float]) -> Scenario:
    """Add effects by ``ids``, then set parameters: ``backlash.gap``, or ``k``, ``T``, ``xi``,
    ``bias``.

    Setting a parameter of an effect adds the effect. Raises InputError for unknown names and for
    values out of bounds.
    """
    effects = {name: dict(values) for name, values in scenario.effects.items()}
    for name in ids:
        effects.setdefault(name, {})
    servo = asdict(scenario.servo)
    for name, value in settings.items():
        effect, dot, parameter = name.partition(".")
        if dot:
            effects.setdefault(effect, {})[parameter] = value
        elif name in servo:
            servo[name] = value
        else:
            raise InputError(
                f"set {name}: no such parameter, expected one of {', '.join(servo)} or "
                f"EFFECT.PARAMETER, such as backlash.gap; correct the name"
            )
    changed = replace(scenario, effects=effects, servo=LinearServo(**servo))
    check_scenario(changed, "set")
    return changed


def parse_settings(texts: Sequence[str]) -> dict[str, float]:
    """``NAME=VALUE`` texts of the command line as a mapping; InputError names the wrong one."""
    settings = {}
    for text in texts:
        name, equals, value = text.partition("=")
        try:
            number: object = float(value) if equals else text
        except ValueError:
            number = value
        settings[name.strip()] = validated_value(number, float, f"--set {text}", "value")
    return settings
