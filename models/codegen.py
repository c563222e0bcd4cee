"""From a registry of effects to one compiled kernel.

The effects' equations are scalar Python functions. This file prints them, with the dispatching
functions of ``terms.py`` and the integrator, into one self-contained source file in the user's
cache folder. Its name carries the hash of its text, so that numba's own cache holds the compiled
kernel across runs, and a user's own effect costs one compilation.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.util
import inspect
import os
import sys
import tempfile
import textwrap
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from servosight.models import integrator, linear_core
from servosight.models.effect import Effect, Place
from servosight.models.errors import InputError
from servosight.models.parameter import CORE, OWN

N_BASE = len(CORE) + len(OWN)
_HEADER = '''"""Plant kernel for: {names}. Written by servosight; delete it freely."""
import math

import numpy as np
from numba import njit, prange
'''


@dataclass(frozen=True)
class Layout:
    """Where each effect's parameters stand in a row, and each term's state and memory."""

    effects: tuple[Effect, ...]
    offsets: tuple[int, ...]
    width: int

    @classmethod
    def of(cls, effects: Iterable[Effect]) -> Layout:
        """Lay out the effects in their order behind the base parameters."""
        ordered = tuple(effects)
        offsets = []
        width = N_BASE
        for effect in ordered:
            offsets.append(width)
            width += len(effect.parameters)
        return cls(ordered, tuple(offsets), width)

    def names(self) -> list[str]:
        """Names of all parameters of a row, effects' as ``effect.parameter``."""
        base = [parameter.name for parameter in CORE + OWN]
        own = [f"{effect.id}.{q.name}" for effect in self.effects for q in effect.parameters]
        return base + own

    def neutral_row(self) -> list[float]:
        """A row in which no effect acts; parameters without a neutral value take their lower bound."""
        row = [1.0, 0.05, 0.7, 0.0, 0.0, 0.0]
        for effect in self.effects:
            row += [q.low if q.neutral is None else q.neutral for q in effect.parameters]
        return row


def source(effects: Iterable[Effect]) -> str:
    """The text of the kernel for these effects, in their order."""
    layout = Layout.of(effects)
    parts = [_HEADER.format(names=", ".join(effect.id for effect in layout.effects) or "none")]
    for effect in layout.effects:
        for role, function in effect.hooks.items():
            parts.append(_printed(function, _symbol(effect, role)))
    parts.append(_dispatchers(layout))
    parts += [_body(linear_core.__file__), _body(integrator.__file__)]
    return "\n\n".join(parts)


def kernel(effects: Mapping[str, Effect]) -> Callable[..., None]:
    """The compiled ``simulate_rows`` for these effects, from the cache where it stands already."""
    text = source(effects.values())
    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    name = f"servosight_kernel_{digest}"
    if name not in sys.modules:
        path = cache_folder() / f"{name}.py"
        if not path.is_file():
            _write(path, text)
        spec = importlib.util.spec_from_file_location(name, path)
        if spec is None or spec.loader is None:  # pragma: no cover - a .py path always has both
            raise RuntimeError(f"cannot import {path}")
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
    function: Callable[..., None] = sys.modules[name].simulate_rows
    return function


def cache_folder() -> Path:
    """Where kernels are kept: SERVOSIGHT_CACHE, else the XDG cache folder, else a temporary one."""
    chosen = os.environ.get("SERVOSIGHT_CACHE")
    base = Path(chosen) if chosen else _default_cache()
    try:
        base.mkdir(parents=True, exist_ok=True)
        if not os.access(base, os.W_OK):
            raise PermissionError(base)
    except OSError:
        base = Path(tempfile.gettempdir()) / f"servosight-{os.getuid()}"
        base.mkdir(mode=0o700, exist_ok=True)
        if base.stat().st_uid != os.getuid():
            raise InputError(
                f"{base}: the kernel cache belongs to another user; expected a folder of your own, "
                f"so set SERVOSIGHT_CACHE to one"
            ) from None
    return base


def _default_cache() -> Path:
    root = os.environ.get("XDG_CACHE_HOME")
    return (Path(root) if root else Path.home() / ".cache") / "servosight"


def _write(path: Path, text: str) -> None:
    handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
    with os.fdopen(handle, "w", encoding="utf-8") as stream:
        stream.write(text)
    os.replace(temporary, path)


def _symbol(effect: Effect, role: str) -> str:
    return f"{effect.id}__{role}"


def _printed(function: Callable[..., Any], symbol: str) -> str:
    """The function's source under a new name, without annotations and docstring."""
    tree = ast.parse(textwrap.dedent(inspect.getsource(function)))
    definition = tree.body[0]
    if not isinstance(definition, ast.FunctionDef):
        raise InputError(f"{symbol}: expected a plain function defined with def")
    definition.name = symbol
    definition.returns = None
    definition.decorator_list = [ast.Name("njit", ast.Load())]
    for argument in definition.args.args:
        argument.annotation = None
    if ast.get_docstring(definition) is not None:
        definition.body = definition.body[1:]
    return ast.unparse(ast.fix_missing_locations(tree))


def _body(path: str | None) -> str:
    """A module's functions with caching switched on, without docstring and imports."""
    assert path is not None
    tree = ast.parse(Path(path).read_text(encoding="utf-8"))
    kept = [
        node
        for node in tree.body[1:]
        if not isinstance(node, ast.Import | ast.ImportFrom)
    ]
    for node in kept:
        if isinstance(node, ast.FunctionDef) and node.name == "simulate_rows":
            node.decorator_list = [
                ast.parse("njit(parallel=True, cache=True, nogil=True)", mode="eval").body
            ]
    return "\n\n".join(ast.unparse(node) for node in kept)


def _dispatchers(layout: Layout) -> str:
    """The functions of terms.py for this layout."""
    writer = _Writer(layout)
    return "\n\n".join(
        [
            writer.constants(),
            writer.flags(),
            writer.queries(),
            writer.command(),
            writer.feedback(),
            writer.drive(),
            writer.friction(),
            writer.load(),
            writer.shaft(),
            writer.output(),
        ]
    )


class _Writer:
    """Prints one dispatching function after the other."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.state: dict[str, int] = {}
        count = 0
        # The shaft's two states come first: the integrator reads the far angle from them.
        for effect in sorted(layout.effects, key=lambda effect: effect.place is not Place.SHAFT):
            self.state[effect.id] = count
            count += effect.states
        self.n_states = count
        shafts = self.at(Place.SHAFT)
        if len(shafts) > 1:
            names = [effect.id for _, effect in shafts]
            raise InputError(f"effects {names}: expected at most one second inertia; leave one out")

    def at(self, place: Place) -> list[tuple[int, Effect]]:
        """Index and effect of those that act at a place."""
        return [(i, e) for i, e in enumerate(self.layout.effects) if e.place is place]

    def values(self, index: int) -> str:
        """The effect's parameters as arguments."""
        start = self.layout.offsets[index]
        count = len(self.layout.effects[index].parameters)
        return ", ".join(f"p[{start + j}]" for j in range(count))

    def constants(self) -> str:
        switches = sum(e.switch is not None for _, e in self.at(Place.DRIVE))
        commands = sum(e.term is not None for _, e in self.at(Place.COMMAND))
        return (
            f"N_EFFECTS = {len(self.layout.effects)}\nN_COMMAND = {commands}\n"
            f"N_MEMORY = {len(self.at(Place.TRANSMISSION))}\nN_STATES = {self.n_states}\n"
            f"N_SWITCHES = {switches}"
        )

    def flags(self) -> str:
        lines = []
        for i, effect in enumerate(self.layout.effects):
            tests = []
            for j, parameter in enumerate(effect.parameters):
                if parameter.neutral is None:
                    continue
                neutral = "math.inf" if parameter.reciprocal else repr(parameter.neutral)
                tests.append(f"p[{self.layout.offsets[i] + j}] != {neutral}")
            lines.append(f"if {' or '.join(tests)}:\n    on[{i}] = 1")
        return _function("raise_flags(p, on)", lines, "return")

    def queries(self) -> str:
        groups = {
            "has_friction": [i for i, _ in self.at(Place.FRICTION)],
            "has_memory": [i for i, _ in self.at(Place.TRANSMISSION)],
            "has_shaft": [i for i, _ in self.at(Place.SHAFT)],
            "has_states": [i for i, e in enumerate(self.layout.effects) if e.states],
            "has_plant_terms": [
                i
                for place in (Place.FEEDBACK, Place.DRIVE, Place.LOAD)
                for i, _ in self.at(place)
            ],
        }
        printed = []
        for name, members in groups.items():
            test = " or ".join(f"on[{i}] == 1" for i in members) or "False"
            printed.append(_function(f"{name}(on)", [], f"return {test}"))
        return "\n\n".join(printed)

    def command(self) -> str:
        delay, start, chain = [], [], []
        slot = 0
        for i, effect in self.at(Place.COMMAND):
            if effect.latency is not None:
                delay.append(f"if on[{i}]:\n    s += {_symbol(effect, 'latency')}({self.values(i)})")
                continue
            call = f"{_symbol(effect, 'term')}"
            start.append(
                f"last[{slot}] = value\nif on[{i}]:\n"
                f"    value, _, _ = {call}(value, 0.0, 1.0, value, {self.values(i)})\n"
                f"    last[{slot}] = value"
            )
            chain.append(
                f"if on[{i}]:\n    value, slope, horizon = {call}(value, slope, horizon, "
                f"last[{slot}], {self.values(i)})\nv[{slot}] = value\ns[{slot}] = slope"
            )
            slot += 1
        limits = [
            f"if on[{i}]:\n    s = min(s, {_symbol(effect, 'resolution')}({self.values(i)}))"
            for i, effect in enumerate(self.layout.effects)
            if effect.resolution is not None
        ]
        return "\n\n".join(
            [
                _function("latency(p, on)", ["s = 0.0", *delay], "return s"),
                _function("longest_step(p, on)", ["s = math.inf", *limits], "return s"),
                _function("command_start(p, on, value, last)", start, "return"),
                _function(
                    "command_chain(p, on, value, slope, horizon, last, v, s)",
                    chain,
                    "return value, slope, horizon",
                ),
            ]
        )

    def feedback(self) -> str:
        lines = [
            f"if on[{i}]:\n    theta = {_symbol(e, 'term')}(theta, {self.values(i)})"
            for i, e in self.at(Place.FEEDBACK)
        ]
        return _function("feedback_chain(p, on, theta)", lines, "return theta")

    def _stateful(self, index: int, effect: Effect, leading: str, target: str, sign: str) -> str:
        """A call whose term may own states; rates go to ``dz``."""
        first = self.state[effect.id]
        states = "".join(f"z[{first + j}], " for j in range(effect.states))
        call = f"{_symbol(effect, 'term')}({leading}, {states}{self.values(index)})"
        if not effect.states:
            return f"if on[{index}]:\n    {target} {sign} {call}"
        rates = ", ".join(f"dz[{first + j}]" for j in range(effect.states))
        return f"if on[{index}]:\n    value, {rates} = {call}\n    {target} {sign} value"

    def drive(self) -> str:
        chain, switches = [], []
        slot = 0
        for i, effect in self.at(Place.DRIVE):
            chain.append(self._stateful(i, effect, "e, w", "e", "="))
            if effect.switch is not None:
                call = f"{_symbol(effect, 'switch')}(e, w, {self.values(i)})"
                switches.append(f"g[{slot}] = 1.0\nif on[{i}]:\n    g[{slot}] = {call}")
                slot += 1
            if not effect.states:
                switches.append(self._stateful(i, effect, "e, w", "e", "="))
        return "\n\n".join(
            [
                _function("drive_chain(p, on, e, w, z, dz)", chain, "return e"),
                _function("drive_switches(p, on, e, w, g)", switches, "return"),
            ]
        )

    def friction(self) -> str:
        lines = ["size = 0.0"] + [
            f"if on[{i}]:\n"
            f"    size += {_symbol(e, 'term')}(speed, drive, load, {self.values(i)})"
            for i, e in self.at(Place.FRICTION)
        ]
        return _function("friction_size(p, on, speed, drive, load)", lines, "return size")

    def load(self) -> str:
        lines = ["torque = 0.0"] + [
            self._stateful(i, e, "theta, w", "torque", "+=") for i, e in self.at(Place.LOAD)
        ]
        return _function("load_sum(p, on, theta, w, z, dz)", lines, "return torque")

    def shaft(self) -> str:
        lines = ["reaction = 0.0", "share = 0.0"]
        for i, effect in self.at(Place.SHAFT):
            lines.append(
                f"if on[{i}]:\n    reaction, share, dz[0], dz[1] = {_symbol(effect, 'term')}"
                f"(theta, w, p[1], z[0], z[1], {self.values(i)})"
            )
        return _function("shaft_term(p, on, theta, w, z, dz)", lines, "return reaction, share")

    def output(self) -> str:
        show, keep = [], []
        for slot, (i, effect) in enumerate(self.at(Place.TRANSMISSION)):
            line = f"angle = {_symbol(effect, 'term')}(angle, memory[{slot}], {self.values(i)})"
            show.append(f"if on[{i}]:\n    {line}")
            keep.append(f"if on[{i}]:\n    {line}\nmemory[{slot}] = angle")
        return "\n\n".join(
            [
                _function("output_chain(p, on, angle, memory)", show, "return angle"),
                _function("memory_commit(p, on, angle, memory)", keep, "return"),
            ]
        )


def _function(signature: str, lines: list[str], end: str) -> str:
    body = textwrap.indent("\n".join([*lines, end]), "    ")
    return f"@njit\ndef {signature}:\n{body}"
