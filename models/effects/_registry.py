"""The registry of effects: the catalogue in its order, and the user's own."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from servosight.models.core import InputError, check_path, did_you_mean, either
from servosight.models.effects._contract import TYPICAL, Effect

CATALOGUE: tuple[str, ...] = (
    "dead_time",
    "command_quantization",
    "rate_limit",
    "motion_profile",
    "velocity_feedforward",
    "integral_action",
    "limited_integral",
    "asymmetric_gain",
    "dead_zone",
    "dead_band",
    "torque_saturation",
    "speed_limit",
    "current_limit",
    "coulomb_friction",
    "stribeck_friction",
    "load_dependent_friction",
    "directional_friction",
    "load_dependent_stribeck",
    "presliding",
    "quadratic_drag",
    "gravity_load",
    "hinge_hardening",
    "known_disturbance",
    "cogging",
    "supply_sag",
    "flexible_shaft",
    "backlash",
    "linkage_geometry",
    "sensor_nonlinearity",
    "feedback_backlash",
)
"""Files in ``models/effects/builtin``; effects in one place act in this order (docs/physics.md)."""


def catalogue(plugins: Sequence[Path] = ()) -> dict[str, Effect]:
    """All effects by identifier: the built-in ones, then those of the plugin files.

    A plugin is a Python file with a module-level ``EFFECT`` (or several, in ``EFFECTS``). Loading
    it runs it: use files that you trust. Raises InputError where a file offers no effect or one
    whose identifier is taken.
    """
    effects = {name: _load(f"servosight.models.effects.builtin.{name}") for name in CATALOGUE}
    for path in plugins:
        for effect in _load_plugin(path):
            if effect.id in effects:
                raise InputError(
                    f"{path}: effect id {effect.id!r} is already in the catalogue; expected a new "
                    f"identifier, so rename it"
                )
            effects[effect.id] = effect
            _check_joined(path, effect, effects)
    return effects


def _check_joined(path: Path, effect: Effect, effects: Mapping[str, Effect]) -> None:
    """What a plugin needs in order to be searched beside the others."""
    if not effect.guesses(TYPICAL):
        raise InputError(
            f"{path}: effect {effect.id}: starts returns no guess, expected at least one"
        )
    for name in effect.contains:
        if name not in effects:
            raise InputError(
                f"{path}: effect {effect.id}: contains names {name!r}{did_you_mean(name, effects)};"
                f" expected effects of the catalogue"
            )
        theirs = [one.unit for one in effects[name].parameters]
        if [one.unit for one in effect.parameters][: len(theirs)] != theirs:
            raise InputError(
                f"{path}: effect {effect.id}: contains names {name!r}, expected the parameters of "
                f"{name} first, in units of {' and '.join(theirs)}"
            )


def select(effects: Mapping[str, Effect], ids: Sequence[str]) -> list[str]:
    """Check identifiers against the catalogue and return them in the catalogue's order."""
    for name in ids:
        if name not in effects:
            raise InputError(
                f"unknown effect {name!r}{did_you_mean(name, effects)}; expected one of "
                f"{', '.join(effects)}: choose from these or bring your own with "
                f"{either('plugins=[FILE.py]', '--plugin FILE.py')}"
            )
    wanted = set(ids)
    return [name for name in effects if name in wanted]


def covered(effects: Iterable[str], catalogue: Mapping[str, Effect]) -> set[str]:
    """Effects, and those that they contain.

    >>> sorted(covered(["current_limit"], catalogue()))
    ['current_limit', 'torque_saturation']
    """
    own = set(effects)
    return own.union(*(catalogue[name].contains for name in own))


def _load(module: str) -> Effect:
    effect = importlib.import_module(module).EFFECT
    assert isinstance(effect, Effect)
    return effect


def _load_plugin(path: Path) -> list[Effect]:
    check_path(path)
    if not path.is_file():
        raise InputError(f"{path}: no such plugin file; expected a Python file with an EFFECT")
    name = f"servosight_plugin_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise InputError(f"{path}: not a Python file; expected a name that ends in .py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except KeyboardInterrupt:
        raise
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    except BaseException as error:  # a plugin may well call sys.exit()
        raise InputError(
            f"{path}: the plugin failed to load ({type(error).__name__}: {_line(error)}); expected "
            f"a Python file that defines EFFECT, so correct that line"
        ) from error
    found = getattr(module, "EFFECTS", None) or (getattr(module, "EFFECT", None),)
    if not isinstance(found, list | tuple) or not all(isinstance(one, Effect) for one in found):
        raise InputError(
            f"{path}: no EFFECT found; expected EFFECT = Effect(...) in that file, or EFFECTS, a "
            f"tuple of them"
        )
    return list(found)


def _line(error: BaseException) -> str:
    return " ".join(str(error).split())[:200]
