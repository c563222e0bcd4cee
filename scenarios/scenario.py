"""A declared experiment: everything that makes a synthetic recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any

from msgspec import Meta

from servosight.models.core import (
    APART,
    Camera,
    InputError,
    check_fields,
    read_settings,
    require,
    validated,
    validated_value,
    within,
)
from servosight.models.effects import catalogue
from servosight.models.excitation import Excitation
from servosight.scenarios.camera_settings import (
    TABLES,
    check_camera,
    check_filming,
    read_filming,
)
from servosight.scenarios.limits import check_effects, check_film, check_motion, check_work
from servosight.scenarios.settings import (
    KINDS,
    CommandSettings,
    DisturbanceSettings,
    LinearServo,
)
from servosight.sim.effects import resolve
from servosight.sim.film import VideoSettings

_TABLES = Meta(
    description="one table for each effect",
    extra={"fix": "write [effects.backlash] and below it gap = 2.0"},
)
Effects = Annotated[Mapping[str, Annotated[Mapping[str, float], _TABLES]], _TABLES]


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
        rows = self.motion.rows(self.duration_s, self.seed)
        known = catalogue()
        if not any(known[name].needs_disturbance for name in self.effects if name in known):
            return rows
        return replace(rows, disturbance=self.disturbance.signals(self.duration_s))

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


def check_scenario(scenario: Scenario, source: str) -> None:
    """Raise InputError, which names ``source`` and the key, for a value that makes no sense."""
    servo, motion, camera = scenario.servo, scenario.motion, scenario.camera
    require(motion.kind in KINDS, source, "motion.kind", motion.kind, f"one of {', '.join(KINDS)}")
    check_fields(scenario, source)
    check_motion(servo, motion, scenario.duration_s, source)
    check_camera(camera, source)
    check_filming(scenario.filming, camera, source)
    check_effects(scenario.effects, source)
    check_work(servo, scenario.effects, scenario.duration_s, source)
    if scenario.video:
        check_film(camera, scenario.duration_s, source)


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
