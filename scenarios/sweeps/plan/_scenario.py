"""The scenario of one cell: the sweep's own, with the axes' values set by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, replace
from functools import cache
from typing import Any

from servosight.models.core import InputError, did_you_mean
from servosight.models.effects import catalogue
from servosight.scenarios.camera_settings import filming_tables
from servosight.scenarios.draws import DRAWS, UNCATALOGUED_DRAWS, hidden_effects
from servosight.scenarios.scenario import Scenario
from servosight.scenarios.sweeps.plan._axes import Settings
from servosight.sim.effects import TWIN_EFFECTS

HIDDEN, STRENGTH = "hidden", "strength"
"""Axes that are no keys of a scenario: which effects are hidden, and how strong they are."""

_OWN = ("seed", "video")
"""Keys that the sweep itself sets."""


def scenario_of(
    base: Mapping[str, Any],
    settings: Settings,
    seed: int,
    draw_seed: int,
    *,
    video: bool,
    source: str = "the sweep",
) -> Scenario:
    """The scenario of a cell.

    ``base`` is a scenario's table and ``settings`` its changes. With the axis ``hidden``, effects,
    servo and amplitude are drawn by ``draw_seed`` (:mod:`servosight.scenarios.draws`) and take
    the place of the base's; other axes are set after that. Raises InputError that names the key.
    """
    table = {key: dict(one) if isinstance(one, Mapping) else one for key, one in base.items()}
    if HIDDEN in settings:
        drawn = _drawn(str(settings[HIDDEN]), draw_seed, settings.get(STRENGTH, 1.0), source)
        table["servo"] = asdict(drawn.servo)
        table["effects"] = {name: _allowed(name, values) for name, values in drawn.effects.items()}
        table["motion"] = {
            **table.get("motion", {}),
            "amplitude_deg": drawn.motion.amplitude_deg,
        }
    elif STRENGTH in settings:
        raise InputError(
            f"{source}: key axes.{STRENGTH} stands alone, expected an axis {HIDDEN} that says "
            f'which effects; add for instance {HIDDEN} = ["backlash"]'
        )
    for name, value in settings.items():
        if name not in (HIDDEN, STRENGTH):
            _set(table, name, value, source)
    try:
        scenario = Scenario.of({**table, "seed": seed, "video": video}, source)
    except InputError as error:
        if str(error).startswith(source):
            raise
        raise InputError(f"{source}: {error}") from None  # the simulation knows of no file
    return replace(scenario, filming=replace(scenario.filming, workers=1))


def hidden_names(scenario: Scenario) -> tuple[str, ...]:
    """The effects of a scenario that do something: a play of 0 deg hides nothing."""
    known = catalogue()
    return tuple(
        name
        for name, values in scenario.effects.items()
        if name not in known
        or not values
        or any(value != known[name].parameter(key).neutral for key, value in values.items())
    )


@cache
def whole_keys() -> frozenset[str]:
    """The keys of a scenario that hold whole numbers."""
    return frozenset(name for name, value in _defaults().items() if type(value) is int)


def _drawn(names: str, seed: int, strength: Any, source: str) -> Scenario:
    effects = [name.strip() for name in names.split("+") if name.strip()]
    known = {**DRAWS, **UNCATALOGUED_DRAWS}
    for name in effects:
        if name not in known:
            raise InputError(
                f"{source}: key axes.{HIDDEN} is {names!r}, expected effects joined by + of "
                f"{', '.join(known)}{did_you_mean(name, known)}; correct the name"
            )
    if isinstance(strength, str) or not strength >= 0.0:
        raise InputError(
            f"{source}: key axes.{STRENGTH} is {strength!r}, expected numbers from 0; correct them"
        )
    return hidden_effects(effects, seed, strength=float(strength))


def _allowed(effect: str, values: Mapping[str, float]) -> dict[str, float]:
    """Values within the bounds of their parameters: a weak effect may reach the end of them."""
    if effect not in catalogue():
        return dict(values)
    bounds = {one.name: (one.low, one.high) for one in catalogue()[effect].parameters}
    return {key: min(max(value, bounds[key][0]), bounds[key][1]) for key, value in values.items()}


def _set(table: dict[str, Any], name: str, value: Any, source: str) -> None:
    """Set a dotted key."""
    if name in _OWN:
        raise InputError(
            f"{source}: key axes.{name} cannot be an axis, expected a key of the scenario that the "
            f"sweep does not set; use seeds and through"
        )
    *path, last = name.split(".")
    if path[:1] == ["effects"]:
        _check_effect(name, source)
    elif name in table_names() or name not in _defaults():
        known = [key for key in _defaults() if key not in _OWN and not key.startswith("effects.")]
        raise InputError(
            f"{source}: unknown key {name}, expected one of {', '.join([HIDDEN, STRENGTH, *known])}"
            f" or effects.EFFECT.PARAMETER{did_you_mean(name, known)}; rename or remove it"
        )
    place = table
    for depth, part in enumerate(path, start=1):
        inner = place.setdefault(part, {})
        if not isinstance(inner, dict):
            raise InputError(
                f"{source}: key axes.{name} goes through {'.'.join(path[:depth])}, which is no "
                f"table; expected a key of the scenario{did_you_mean(name, _defaults())}; correct "
                f"the name"
            )
        place[part] = place = dict(inner)
    place[last] = value


def _check_effect(name: str, source: str) -> None:
    """Refuse an effect, or a parameter, that cannot be simulated."""
    known = [key for key in _defaults() if key.startswith("effects.")]
    if name not in known:
        effect = name.split(".")[1]
        mine = [key for key in known if key.split(".")[1] == effect]
        effects = list(dict.fromkeys(key.split(".")[1] for key in known))
        expected = ", ".join(mine) if mine else f"effects.EFFECT.PARAMETER of {', '.join(effects)}"
        raise InputError(
            f"{source}: unknown key {name}, expected {'one of ' if mine else ''}{expected}"
            f"{did_you_mean(name, known)}; rename or remove it"
        )


@cache
def table_names() -> frozenset[str]:
    """The tables of a scenario."""
    return frozenset(name.partition(".")[0] for name in _defaults() if "." in name)


@cache
def _defaults() -> dict[str, Any]:
    """Every key of a scenario by its dotted name, with its default; effects as far as built."""
    plain = Scenario()
    table = {**asdict(plain), **filming_tables(plain.filming)}
    del table["filming"]
    table["effects"] = {name: dict(one.defaults) for name, one in TWIN_EFFECTS.items()}
    return dict(_flat(table))


def _flat(table: Mapping[str, Any], prefix: str = "") -> list[tuple[str, Any]]:
    found: list[tuple[str, Any]] = []
    for key, value in table.items():
        if isinstance(value, Mapping):
            found += _flat(value, f"{prefix}{key}.")
        else:
            found.append((prefix + key, value))
    return found
