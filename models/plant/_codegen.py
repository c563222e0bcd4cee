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
import logging
import os
import sys
import tempfile
import textwrap
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from servosight.models.core import CORE, OWN, InputError, write_text
from servosight.models.effects import Effect, Place, parsed
from servosight.models.plant import _integrator as integrator
from servosight.models.plant import _linear_core as linear_core

N_BASE = len(CORE) + len(OWN)
_HEADER = '''"""Plant kernel for: {names}. Written by servosight; delete it freely."""
import math

import functools

import numpy as np
from numba import njit as compiled, prange

njit = functools.partial(compiled, error_model="numpy", forceinline=True)
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
        """A row in which no effect acts; parameters without neutral value take their low bound."""
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
    parts += [_body(linear_core.__file__), _dispatchers(layout)]
    parts.append(_body(integrator.__file__))
    return "\n\n".join(parts)


def kernel(effects: Mapping[str, Effect]) -> Callable[..., None]:
    """The compiled ``simulate_rows`` for these effects, from the cache where it stands already."""
    text = source(effects.values())
    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    name = f"servosight_kernel_{digest}"
    if name not in sys.modules:
        path = cache_folder() / f"{name}.py"
        if not path.is_file():
            write_text(path, text)
            logging.getLogger("servosight").info(
                "compiling the equations of %d effects, once; this takes up to a minute",
                len(effects),
            )
        spec = importlib.util.spec_from_file_location(name, path)
        if spec is None or spec.loader is None:  # pragma: no cover - a .py path always has both
            raise RuntimeError(f"cannot import {path}")
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module
        spec.loader.exec_module(module)
    function: Callable[..., None] = sys.modules[name].simulate_rows
    return function


def not_compiled(effects: Iterable[Effect], error: Exception) -> Exception:
    """What to raise where a kernel cannot be compiled: the sentence on the effect that is why."""
    from numba import float64, njit
    from numba.core.errors import NumbaError

    if not isinstance(error, NumbaError):
        return error
    for effect in effects:
        for role, function in effect.hooks.items():
            count = len(inspect.signature(function).parameters)
            try:
                njit(error_model="numpy")(function).compile((float64,) * count)
            except NumbaError as reason:
                lines = [line.strip() for line in str(reason).splitlines() if line.strip()]
                why = next((line for line in lines if "Failed in" not in line), "")[:120]
                return InputError(
                    f"effect {effect.id} ({effect.place.value}): {role} cannot be compiled "
                    f"({why}); expected arithmetic on numbers, if and for, so write it in these"
                )
    return error


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


def _symbol(effect: Effect, role: str) -> str:
    return f"{effect.id}__{role}"


def _printed(function: Callable[..., Any], symbol: str) -> str:
    """The function's source under a new name, without annotations and docstring."""
    definition = parsed(symbol, function)
    definition.name = symbol
    definition.returns = None
    definition.decorator_list = [ast.Name("njit", ast.Load())]
    for argument in definition.args.args:
        argument.annotation = None
    if ast.get_docstring(definition) is not None:
        definition.body = definition.body[1:]
    return ast.unparse(ast.fix_missing_locations(definition))


def _body(path: str | None) -> str:
    """A module's functions with caching switched on, without docstring and imports."""
    assert path is not None
    tree = ast.parse(Path(path).read_text(encoding="utf-8"))
    kept = [node for node in tree.body[1:] if not isinstance(node, ast.Import | ast.ImportFrom)]
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
            writer.rows(),
            writer.queries(),
            writer.states(),
            writer.command(),
            writer.pace(),
            writer.torques(),
            writer.switches(),
            writer.friction(),
            writer.output(),
        ]
    )


class _Writer:
    """Prints one dispatching function after the other."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.state: dict[str, int] = {}
        count = 0
        # The shaft's two states come first: the integrator reads the far angle from them. What a
        # term remembers from one turn of the motor to the next stands behind all states.
        for effect in sorted(layout.effects, key=lambda effect: effect.place is not Place.SHAFT):
            self.state[effect.id] = count
            count += effect.states
        self.n_states = count = max(count, 2)
        for effect in layout.effects:
            if effect.memory:
                self.state[effect.id] = count
                count += effect.memory
        self.n_slots = count
        shafts = self.at(Place.SHAFT)
        if len(shafts) > 1:
            names = [effect.id for _, effect in shafts]
            raise InputError(f"effects {names}: expected at most one second inertia; leave one out")

    def at(self, place: Place) -> list[tuple[int, Effect]]:
        """Index and effect of those that act at a place."""
        return [(i, e) for i, e in enumerate(self.layout.effects) if e.place is place]

    def any_at(self, place: Place) -> int:
        """Where the flags say that an effect acts at a place; behind those of the effects."""
        return len(self.layout.effects) + list(Place).index(place)

    def guarded(self, place: Place, lines: list[str]) -> list[str]:
        """Lines that are passed over where nothing acts at a place."""
        if not lines:
            return []
        return [f"if on[{self.any_at(place)}]:\n" + textwrap.indent("\n".join(lines), "    ")]

    def values(self, index: int) -> str:
        """The effect's parameters as arguments."""
        start = self.layout.offsets[index]
        count = len(self.layout.effects[index].parameters)
        return ", ".join(f"p[{start + j}]" for j in range(count))

    def constants(self) -> str:
        switches = sum(effect.switch is not None for effect in self.layout.effects)
        commands = sum(e.term is not None for _, e in self.at(Place.COMMAND))
        return (
            f"N_COMMAND = {commands}\nN_MEMORY = {len(self.at(Place.TRANSMISSION))}\n"
            f"N_SWITCHES = {switches}"
        )

    def rows(self) -> str:
        lines = []
        for i, (effect, offset) in enumerate(
            zip(self.layout.effects, self.layout.offsets, strict=True)
        ):
            away = [
                f"p[{offset + j}] != {'math.inf' if q.reciprocal else repr(q.neutral)}"
                for j, q in enumerate(effect.parameters)
                if q.neutral is not None
            ]
            lines.append(f"f{i} = {' or '.join(away)}")
        # Each test has a name first: numba reads no long tuple with branches in it.
        for place in Place:
            acts = _any([f"f{i}" for i, _ in self.at(place)])
            lines.append(f"f{self.any_at(place)} = {acts}")
        tests = ", ".join(f"f{i}" for i in range(len(self.layout.effects) + len(Place)))
        row = ", ".join(f"row[{j}]" for j in range(self.layout.width))
        return "\n\n".join(
            [
                _function("unpack(row)", [], f"return ({row},)"),
                _function("flags(p)", lines, f"return ({tests})"),
            ]
        )

    def queries(self) -> str:
        varying = [i for i, e in self.at(Place.FRICTION) if not _steady(e)]
        plant = (Place.REDUCER, Place.FEEDBACK, Place.DRIVE, Place.LOAD, Place.BRISTLE)
        effects = list(enumerate(self.layout.effects))
        groups = {
            "has_command_terms": [i for i, e in self.at(Place.COMMAND) if e.term is not None],
            "has_friction": [self.any_at(Place.FRICTION)],
            "has_varying_friction": varying,
            "has_memory": [self.any_at(Place.TRANSMISSION)],
            "has_loop_memory": [i for i, e in effects if e.memory],
            "has_switches": [i for i, e in effects if e.switch is not None],
            "has_resolutions": [i for i, e in effects if e.resolution is not None],
            "has_shaft": [self.any_at(Place.SHAFT)],
            "has_states": [i for i, e in effects if e.states],
            "has_plant_terms": [self.any_at(place) for place in plant],
        }
        return "\n\n".join(
            _function(f"{name}(on)", [], f"return {_any([f'on[{i}]' for i in members])}")
            for name, members in groups.items()
        )

    def states(self) -> str:
        count = range(self.n_states)
        start = ["p[4]", "p[5]"] if self.at(Place.SHAFT) else ["0.0", "0.0"]
        start += ["0.0"] * (self.n_states - 2)
        held = [f"z[{i}]" for i in range(self.n_states, self.n_slots)]
        added = ", ".join([f"z[{i}] + h * r[{i}]" for i in count] + held)
        cubics = [f"cubic(tau, h, z[{i}], r0[{i}], z1[{i}], r1[{i}])" for i in count]
        mixed = ", ".join(cubics + held)
        lines = [f"m{i} = z[{i}]" for i in range(self.n_states, self.n_slots)] + ["felt = theta"]
        for i, effect in enumerate(self.layout.effects):
            slot = self.state[effect.id]
            if effect.place is Place.REDUCER:
                start.append("p[4]")
                call = self._hysteresis(i, effect, "felt")
                lines.append(f"if on[{i}]:\n    felt = m{slot} = {call}")
            if effect.place is Place.BRISTLE:
                start += ["p[4]", "0.0"]
                call = self._hysteresis(i, effect)
                lines.append(f"if on[{i}]:\n    m{slot} = theta\n    m{slot + 1} = {call}")
        kept = [f"z[{i}]" for i in count] + [f"m{i}" for i in range(self.n_states, self.n_slots)]
        return "\n\n".join(
            [
                _function("start_states(p)", [], f"return ({', '.join(start)})"),
                _function("add_scaled(z, h, r)", [], f"return ({added})"),
                _function("between_states(tau, h, z, r0, z1, r1)", [], f"return ({mixed})"),
                _function("keep_memory(p, on, theta, z)", lines, f"return ({', '.join(kept)})"),
            ]
        )

    def _hysteresis(self, index: int, effect: Effect, angle: str = "theta") -> str:
        """A call of a term that remembers the last turn of the motor."""
        first = self.state[effect.id]
        kept = "".join(f"z[{first + j}], " for j in range(effect.memory))
        return f"{_symbol(effect, 'term')}({angle}, {kept}{self.values(index)})"

    def command(self) -> str:
        delay, start, chain = [], [], []
        slot = 0
        for i, effect in self.at(Place.COMMAND):
            if effect.latency is not None:
                call = f"{_symbol(effect, 'latency')}({self.values(i)})"
                delay.append(f"if on[{i}]:\n    s += {call}")
                continue
            call = _symbol(effect, "term")
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
        return "\n\n".join(
            [
                _function("latency(p, on)", ["s = 0.0", *delay], "return s"),
                _function("command_start(p, on, value, last)", start, "return"),
                _function(
                    "command_chain(p, on, value, slope, horizon, last, v, s)",
                    chain,
                    "return value, slope, horizon",
                ),
            ]
        )

    def pace(self) -> str:
        lines = ["s = math.inf"]
        for i, effect in enumerate(self.layout.effects):
            if effect.resolution is None:
                continue
            at = {"T": "p[1]", "last": f"z[{self.state[effect.id] + effect.memory - 1}]"}
            names = list(inspect.signature(effect.resolution).parameters)
            taken = names[: len(names) - len(effect.parameters)]
            motion = "".join(f"{at.get(name, name)}, " for name in taken)
            call = f"{_symbol(effect, 'resolution')}({motion}{self.values(i)})"
            lines.append(f"if on[{i}]:\n    s = min(s, {call})")
        return _function("longest_step(p, on, theta, w, acceleration, z)", lines, "return s")

    def _reducer(self) -> list[str]:
        """Lines that compute the angle behind the reducer, ``felt``."""
        chain = [
            f"if on[{i}]:\n    felt = {self._hysteresis(i, effect, 'felt')}"
            for i, effect in self.at(Place.REDUCER)
        ]
        return ["felt = theta", *self.guarded(Place.REDUCER, chain)]

    def _feedback(self) -> list[str]:
        """Lines that compute ``e`` from force and ``felt`` through the feedback terms."""
        lines = []
        for i, effect in self.at(Place.FEEDBACK):
            call = f"{_symbol(effect, 'term')}(felt, {self.values(i)})"
            lines.append(f"if on[{i}]:\n    felt = {call}")
        return [*self.guarded(Place.FEEDBACK, lines), "e = force - felt"]

    def _stateful(self, index: int, effect: Effect, leading: str, target: str, sign: str) -> str:
        """A call whose term may own states; their rates are ``r0``, ``r1``, ..."""
        first = self.state[effect.id]
        states = "".join(f"z[{first + j}], " for j in range(effect.states))
        call = f"{_symbol(effect, 'term')}({leading}, {states}{self.values(index)})"
        if not effect.states:
            return f"if on[{index}]:\n    {target} {sign} {call}"
        rates = ", ".join(f"r{first + j}" for j in range(effect.states))
        return f"if on[{index}]:\n    value, {rates} = {call}\n    {target} {sign} value"

    def _load(self) -> list[str]:
        """Lines that sum the torques on the motor's side, ``load``."""
        loads = [self._stateful(i, f, "theta, w", "load", "+=") for i, f in self.at(Place.LOAD)]
        bristles = [
            f"if on[{i}]:\n    load += {self._hysteresis(i, effect)}"
            for i, effect in self.at(Place.BRISTLE)
        ]
        return [
            "load = 0.0",
            *self.guarded(Place.LOAD, loads),
            *self.guarded(Place.BRISTLE, bristles),
        ]

    def torques(self) -> str:
        rates = [f"r{i}" for i in range(self.n_states)]
        lines = [f"{rate} = 0.0" for rate in rates]
        lines += self._reducer() + self._feedback()
        drives = [self._stateful(i, f, "e, w", "e", "=") for i, f in self.at(Place.DRIVE)]
        lines += self.guarded(Place.DRIVE, drives)
        lines += self._load()
        lines.append("reaction = 0.0\nshare = 0.0")
        for i, effect in self.at(Place.SHAFT):
            call = f"{_symbol(effect, 'term')}(theta, w, p[1], z[0], z[1], {self.values(i)})"
            lines.append(f"if on[{i}]:\n    reaction, share, r0, r1 = {call}")
        rates += ["0.0"] * (self.n_slots - self.n_states)
        end = f"return e, load, reaction, share, ({', '.join(rates)})"
        return _function("torques(p, on, force, theta, w, z)", lines, end)

    def switches(self) -> str:
        """The chain of ``torques`` once more, with each switch ahead of its own term."""
        lines = ["felt = theta"]
        names: list[str] = []

        def watch(index: int, effect: Effect, leading: str) -> None:
            if effect.switch is None:
                return
            first = self.state[effect.id]
            slots = "".join(f"z[{first + j}], " for j in range(effect.states + effect.memory))
            name = f"g{len(names)}"
            call = f"{_symbol(effect, 'switch')}({leading}, {slots}{self.values(index)})"
            lines.append(f"{name} = 1.0\nif on[{index}]:\n    {name} = {call}")
            names.append(name)

        for i, effect in self.at(Place.REDUCER):
            watch(i, effect, "felt")
            lines.append(f"if on[{i}]:\n    felt = {self._hysteresis(i, effect, 'felt')}")
        lines += self._feedback()
        for i, effect in self.at(Place.DRIVE):
            watch(i, effect, "e, w")
            lines.append(self._stateful(i, effect, "e, w", "e", "="))
        lines += self._load()
        for i, effect in self.at(Place.FRICTION):
            watch(i, effect, "abs(w), e, load")
        end = f"return ({', '.join([*names, '1.0'])},)"
        return _function("kinks(p, on, force, theta, w, z)", lines, end)

    def friction(self) -> str:
        terms = [
            f"if on[{i}]:\n    size += {_symbol(e, 'term')}(speed, drive, load, {self.values(i)})"
            for i, e in self.at(Place.FRICTION)
        ]
        lines = ["size = 0.0", *terms]
        return _function("friction_size(p, on, speed, drive, load)", lines, "return size")

    def output(self) -> str:
        show, keep = [], []
        for slot, (i, effect) in enumerate(self.at(Place.TRANSMISSION)):
            line = f"angle = {_symbol(effect, 'term')}(angle, memory[{slot}], {self.values(i)})"
            show.append(f"if on[{i}]:\n    {line}")
            keep.append(f"if on[{i}]:\n    {line}\nmemory[{slot}] = angle")
        return "\n\n".join(
            [
                _function("reducer_angle(p, on, theta, z)", self._reducer(), "return felt"),
                _function(
                    "output_chain(p, on, angle, memory)",
                    self.guarded(Place.TRANSMISSION, show),
                    "return angle",
                ),
                _function("memory_commit(p, on, angle, memory)", keep, "return"),
            ]
        )


def _steady(friction: Effect) -> bool:
    """True where a friction term reads nothing of the motion: its size is its parameters' alone."""
    assert friction.term is not None
    tree = ast.parse(textwrap.dedent(inspect.getsource(friction.term)))
    read = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    motion = list(inspect.signature(friction.term).parameters)[:3]
    return read.isdisjoint(motion)


def _any(names: list[str]) -> str:
    return " or ".join(names) or "False"


def _function(signature: str, lines: list[str], end: str) -> str:
    body = textwrap.indent("\n".join([*lines, end]), "    ")
    return f"@njit\ndef {signature}:\n{body}"
