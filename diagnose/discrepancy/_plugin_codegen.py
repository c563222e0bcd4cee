"""The source of a plugin: a law as effects, which a user reads, names and runs."""

from __future__ import annotations

import inspect
import json
import textwrap
from collections.abc import Mapping, Sequence

from servosight.models.core import FIXED, TORQUE, Parameter, Scaling
from servosight.models.effects import Effect

PREFIX = "found_"
"""What a draft puts before a term's name: identifiers of effects are taken once."""

_HEAD = '''"""Drafted by servosight diagnose: terms without a name yet.

{said}

Read each equation. Where it makes sense, give it a name (id, and the file's), a cause and a test by
hand; then `servosight diagnose REC --auto --plugin THIS_FILE.py` tries it with the other effects.
"""

import math

from servosight.models.effects import Effect, GuessFeatures, Place
from servosight.models.core import FIXED, TORQUE, Parameter, Scaling
'''

_EFFECT = """
{name} = Effect(
    id={id},
    place=Place.{place},
    parameters=(
{parameters}    ),
    equation={equation},
    looks_like="fill in: how it shows in a recording",
    cause="fill in: what in the servo causes it",
    confirm="fill in: a test by hand that only this passes",
    remedy="fill in: what helps against it",
    source="drafted from a recording by servosight diagnose",
    starts={name}_starts,
    term={name}_term,
{more})
"""


def plugin_source(effects: Sequence[Effect], values: Mapping[str, float], said: str) -> str:
    """Python source with the effects under ``found_...`` identifiers, as ``EFFECTS``.

    ``values`` ("effect.parameter") are where a fit of them starts.
    """
    parts = [_HEAD.format(said=textwrap.fill(said, 100))]
    parts += [_drafted(effect, values) for effect in effects]
    names = "".join(f"{_name(effect)}, " for effect in effects)
    return "\n".join([*parts, f"EFFECTS = ({names.rstrip()})\n"])


def _name(effect: Effect) -> str:
    return f"{PREFIX}{effect.id}"


def _drafted(effect: Effect, values: Mapping[str, float]) -> str:
    """One effect: its functions, its starts and its declaration."""
    name = _name(effect)
    functions = []
    for role, function in effect.hooks.items():
        text = textwrap.dedent(inspect.getsource(function))
        functions.append("\n" + text.replace(f"def {function.__name__}(", f"def {name}_{role}(", 1))
    found = [values[f"{effect.id}.{parameter.name}"] for parameter in effect.parameters]
    start = ", ".join(f"{value:.6g}" for value in found)
    starts = (
        f"\ndef {name}_starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:\n"
        f'    """What the recording showed."""\n    return (({start},),)\n'
    )
    more = "".join(f"    {role}={name}_{role},\n" for role in effect.hooks if role != "term")
    more += f"    states={effect.states},\n" if effect.states else ""
    declared = _EFFECT.format(
        name=name,
        id=json.dumps(name),
        place=effect.place.name,
        parameters="".join(f"        {_parameter(q)},\n" for q in effect.parameters),
        equation=json.dumps(effect.equation),
        more=more,
    )
    return "\n".join([*functions, starts, declared])


def _parameter(parameter: Parameter) -> str:
    """A parameter's declaration, a line for each of its parts."""
    lines = [
        f"{json.dumps(parameter.name)}, {json.dumps(parameter.unit)}",
        f"low={parameter.low!r}, high={parameter.high!r}, neutral={parameter.neutral!r}",
        f"meaning={json.dumps(parameter.meaning)}",
        f"scaling={_scaling(parameter.scaling)}",
    ]
    return "Parameter(\n" + "".join(f"            {line},\n" for line in lines) + "        )"


def _scaling(scaling: Scaling) -> str:
    known = {FIXED: "FIXED", TORQUE: "TORQUE"}
    return known.get(scaling, f"Scaling(gain={scaling.gain!r}, load={scaling.load!r})")
