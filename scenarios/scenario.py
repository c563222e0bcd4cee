"""A declared experiment: everything that makes a synthetic recording."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from servosight.models import excitation as shapes
from servosight.models.core import Array, Camera, InputError, read_settings
from servosight.models.effects import catalogue
from servosight.models.excitation import Excitation
from servosight.scenarios.camera_settings import TABLES, check_camera, check_filming, read_filming
from servosight.scenarios.draws import DRAWS, UNCATALOGUED_DRAWS, USUAL, scaled
from servosight.scenarios.toml_table import read_number, read_table, require
from servosight.sim.bench import BenchParameters
from servosight.sim.effects import resolve
from servosight.sim.film import VideoSettings

Effects = Mapping[str, Mapping[str, float]]

SHORTEST_T_S = 0.002


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
    """The command: a ``kind`` of :data:`KINDS`, in rows at ``rate_hz``.

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
KINDS = ("standard", *_SHAPES)


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
    return _checked(replace(scenario, effects=effects, servo=Response(**servo)), "--set")


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


def hidden(seed: int, *, video: bool = True) -> Scenario:
    """A short scenario with an effect that the user is not told.

    As many seeds in a row as there are effects hide each of them once; strength, servo and command
    vary as well.
    """
    require(seed >= 0, "--seed", "seed", seed, "a whole number from 0")
    names = list(DRAWS)
    block, place = divmod(seed, len(names))
    order = np.random.default_rng(block).permutation(len(names))
    return hidden_effects([names[order[place]]], seed, video=video)


def hidden_effects(
    effects: Sequence[str], seed: int, *, strength: float = 1.0, video: bool = False
) -> Scenario:
    """The scenario that shows ``effects`` clearly, or a servo without any; drawn by ``seed``.

    ``strength`` scales those of the catalogue (:func:`servosight.scenarios.draws.scaled`); the
    servo and the command are the same at any strength. Several effects share the servo of the
    first that needs a special one, and the widest motion.
    """
    draws = {name: {**DRAWS, **UNCATALOGUED_DRAWS}[name] for name in effects}
    special = [draw for draw in draws.values() if (draw.T, draw.xi) != (USUAL.T, USUAL.xi)]
    servo = (special or [USUAL])[0]
    rng = np.random.default_rng([seed, 1])

    def pick(low: float, high: float) -> float:
        return float(f"{rng.uniform(low, high):.4g}")

    values = {
        name: {key: pick(*span) for key, span in draw.parameters.items()}
        for name, draw in draws.items()
    }
    bias = pick(-1.0, 1.0)
    values |= {name: scaled(name, values[name], strength) for name in effects if name in DRAWS}
    bias += sum(values[name].get(draw.trimmed, 0.0) for name, draw in draws.items())
    return Scenario(
        seed=seed,
        duration_s=12.0,
        video=video,
        servo=Response(pick(0.95, 1.05), pick(*servo.T), pick(*servo.xi), bias),
        motion=Motion(amplitude_deg=max(draw.amplitude_deg for draw in (USUAL, *draws.values()))),
        camera=Camera(rate_hz=120.0, exposure_s=0.002),
        effects=values,
    )


def hidden_effect(effect: str, seed: int, *, video: bool = False) -> Scenario:
    """:func:`hidden_effects` with one effect at its usual strength."""
    return hidden_effects([effect], seed, video=video)


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
    return _checked(
        replace(
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
        ),
        source,
    )


def _checked(scenario: Scenario, source: str) -> Scenario:
    """The scenario, if its numbers make sense; InputError names the key that does not."""
    servo, motion = scenario.servo, scenario.motion
    low, high = 1.0, 600.0
    checks: list[tuple[bool, str, object, str]] = [
        (scenario.seed >= 0, "seed", scenario.seed, "a whole number from 0"),
        (
            low <= scenario.duration_s <= high,
            "duration_s",
            scenario.duration_s,
            f"{low:g} to {high:g} seconds",
        ),
        (scenario.noise_deg >= 0.0, "noise_deg", scenario.noise_deg, "0 or more degrees"),
        (servo.k != 0.0, "servo.k", servo.k, "a gain that is not 0"),
        (
            SHORTEST_T_S <= servo.T <= 2.0,
            "servo.T",
            servo.T,
            f"{SHORTEST_T_S:g} to 2 seconds",
        ),
        (0.02 <= servo.xi <= 20.0, "servo.xi", servo.xi, "0.02 to 20"),
        (motion.kind in KINDS, "motion.kind", motion.kind, f"one of {', '.join(KINDS)}"),
        (1.0 <= motion.rate_hz <= 1e4, "motion.rate_hz", motion.rate_hz, "1 to 10000 Hz"),
        (motion.dwell_s > 0.0, "motion.dwell_s", motion.dwell_s, "more than 0 seconds"),
        (0.0 < motion.low_hz < motion.high_hz, "motion.low_hz", motion.low_hz, "0 to high_hz"),
    ]
    for holds, key, value, expected in checks:
        require(holds, source, key, value, expected)
    check_camera(scenario.camera, source)
    check_filming(scenario.filming, scenario.camera, source)
    known = catalogue()
    for effect, values in resolve(scenario.effects).items():
        for name, value in values.items():
            holds, expected = value > 0.0, "more than 0"
            if effect in known:
                bounds = known[effect].parameter(name)
                holds = bounds.low <= value <= bounds.high and np.isfinite(value)
                expected = f"{bounds.low:g} to {bounds.high:g} {bounds.unit}"
            require(holds, source, f"{effect}.{name}", value, expected)
    return scenario
