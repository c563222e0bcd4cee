"""A declared experiment: everything that makes a synthetic recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models import excitation as shapes
from servosight.models.core import Array, Camera, InputError, read_settings
from servosight.models.excitation import Excitation
from servosight.scenarios.camera_settings import TABLES, read_filming
from servosight.scenarios.limits import check_scenario
from servosight.scenarios.toml_table import read_number, read_table
from servosight.sim.bench import BenchParameters
from servosight.sim.effects import resolve
from servosight.sim.film import VideoSettings

Effects = Mapping[str, Mapping[str, float]]


@dataclass(frozen=True)
class Response:
    """The servo's true linear model: k [-], T [s], xi [-], and the angle at zero command [deg]."""

    k: float = 1.0
    T: float = 0.02
    xi: float = 0.6
    bias: float = 0.0

    def bench(self) -> BenchParameters:
        """A twin that has this model."""
        return BenchParameters.with_response(self.k, self.T, self.xi, self.bias)


@dataclass(frozen=True)
class Motion:
    """The command: a ``kind`` of ``limits.KINDS``, in rows at ``rate_hz``.

    ``dwell_s`` is for steps, ``frequency_hz`` for sine and triangle, ``low_hz`` and ``high_hz``
    for chirp and multisine.
    """

    kind: str = "standard"
    amplitude_deg: float = 20.0
    rate_hz: float = 250.0
    dwell_s: float = 0.8
    frequency_hz: float = 1.0
    low_hz: float = 0.5
    high_hz: float = 9.0


Shape = Callable[[Array, Motion, int], Array]

_SHAPES: Mapping[str, Shape] = {
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

    seed: int = 0
    duration_s: float = 20.0
    noise_deg: float = 0.03
    video: bool = False
    servo: Response = field(default_factory=Response)
    motion: Motion = field(default_factory=Motion)
    camera: Camera = field(default_factory=Camera)
    filming: VideoSettings = field(default_factory=VideoSettings)
    effects: Effects = field(default_factory=dict)

    @classmethod
    def load(cls, path: Path) -> Scenario:
        """Read a scenario; InputError names the file, the key and what was expected.

        Keys are the fields' names; ``[servo]``, ``[motion]``, ``[camera]``, those of
        docs/camera.md and ``[effects.ID]`` are tables.
        """
        table = read_settings(path, "a scenario in TOML, with lines such as duration_s = 20.0")
        return _read(table, str(path))

    def excitation(self) -> Excitation:
        """The command's rows."""
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
                f"--set {name}: no such parameter, expected one of {', '.join(servo)} or "
                f"EFFECT.PARAMETER; write for instance backlash.gap=2"
            )
    changed = replace(scenario, effects=effects, servo=Response(**servo))
    check_scenario(changed, "--set")
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
        settings[name.strip()] = read_number(number, f"--set {text}: value")
    return settings


def _read(table: Mapping[str, Any], source: str) -> Scenario:
    parts = ("servo", "motion", "camera", *TABLES, "effects")
    scenario = read_table(Scenario, table, source, "", also=parts)
    effects = table.get("effects", {})
    if not isinstance(effects, Mapping) or not all(
        isinstance(values, Mapping) for values in effects.values()
    ):
        raise InputError(
            f"{source}: key effects is {effects!r}, expected one table for each effect; write "
            f"[effects.backlash] and below it gap = 2.0"
        )
    scenario = replace(
        scenario,
        servo=read_table(Response, table.get("servo", {}), source, "servo"),
        motion=read_table(Motion, table.get("motion", {}), source, "motion"),
        camera=read_table(Camera, table.get("camera", {}), source, "camera"),
        filming=read_filming(table, source),
        effects={
            name: {
                key: read_number(value, f"{source}: key effects.{name}.{key}")
                for key, value in values.items()
            }
            for name, values in effects.items()
        },
    )
    check_scenario(scenario, source)
    return scenario
