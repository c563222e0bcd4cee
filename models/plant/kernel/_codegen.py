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
from collections.abc import Callable, Iterable, Mapping
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType
from typing import Any

from servosight.models.core import InputError, write_text
from servosight.models.effects import Effect, parsed
from servosight.models.plant.kernel import _integrator as integrator
from servosight.models.plant.kernel import _linear_core as linear_core
from servosight.models.plant.kernel import _piece as piece
from servosight.models.plant.kernel import _steps as steps
from servosight.models.plant.kernel._calls import Slots, symbol
from servosight.models.plant.kernel._layout import Layout
from servosight.models.plant.kernel._print_motion import friction, output, torques
from servosight.models.plant.kernel._print_setup import (
    command,
    constants,
    pace,
    queries,
    rows,
    states,
)

_HEADER = '''"""Plant kernel for: {names}. Written by servosight; delete it freely."""
import math

import functools

import numpy as np
from numba import njit as compiled, prange

njit = functools.partial(
    compiled, error_model="numpy", forceinline=True, no_cpython_wrapper=True, no_cfunc_wrapper=True
)
'''


_CALLED = "cache=True, nogil=True, no_cpython_wrapper=False, no_cfunc_wrapper=False"
ENTRIES = {
    "simulate_rows": f"njit(parallel=True, {_CALLED})",
    "shape_command": f"njit({_CALLED})",
    "shape_output": f"njit({_CALLED})",
    "filter_rows": f"njit({_CALLED})",
}
"""The functions that are called from outside, and how they are compiled: they alone need the
wrappers by which Python calls them, which cost a sixth of the time to compile."""


def kernel_source(effects: Iterable[Effect]) -> str:
    """The text of the kernel for these effects, in their order."""
    layout = Layout.of(effects)
    parts = [_HEADER.format(names=", ".join(effect.id for effect in layout.effects) or "none")]
    for effect in layout.effects:
        for role, function in effect.hooks.items():
            parts.append(_printed(function, symbol(effect, role)))
    parts += [_body(linear_core.__file__), _dispatchers(layout)]
    parts += [_body(module.__file__) for module in (steps, piece, integrator)]
    return "\n\n".join(parts)


class _TextLoader(SourceFileLoader):
    """Imports a file from its text alone: of a file of bytecode a full disk could leave half."""

    def get_code(self, fullname: str) -> CodeType:
        path = self.get_filename(fullname)
        return self.source_to_code(self.get_data(path), path)


def kernel(effects: Mapping[str, Effect]) -> tuple[Callable[..., Any], ...]:
    """The functions :data:`ENTRIES` of the kernel for these effects, in that order.

    Each is compiled when it is called, or comes from the cache where it stands already.

    Threads that have nothing to simulate look for work a thousand times, some microseconds, and
    then sleep, unless ``OMP_WAIT_POLICY`` and ``GOMP_SPINCOUNT`` say otherwise: where another
    program needs a core, threads that wait actively slow simulations threefold.
    """
    os.environ.setdefault("OMP_WAIT_POLICY", "passive")  # both are read when threads start
    os.environ.setdefault("GOMP_SPINCOUNT", "1000")
    text = kernel_source(effects.values())
    digest = hashlib.sha256(text.encode()).hexdigest()[:16]
    module_name = f"servosight_kernel_{digest}"
    if module_name not in sys.modules:
        path = cache_folder() / f"{module_name}.py"
        if not path.is_file():
            write_text(path, text)
        if not any((path.parent / "__pycache__").glob(f"{module_name}.*.nbi")):
            logging.getLogger("servosight").info(
                "compiling the equations of %d effects, once; this takes up to a minute",
                len(effects),
            )
        loader = _TextLoader(module_name, str(path))
        spec = importlib.util.spec_from_file_location(module_name, path, loader=loader)
        if spec is None:  # pragma: no cover - a .py path always has one
            raise RuntimeError(f"cannot import {path}")
        module = importlib.util.module_from_spec(spec)
        sys.modules[module_name] = module
        loader.exec_module(module)
    return tuple(getattr(sys.modules[module_name], name) for name in ENTRIES)


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
        if isinstance(node, ast.FunctionDef) and node.name in ENTRIES:
            node.decorator_list = [ast.parse(ENTRIES[node.name], mode="eval").body]
    return "\n\n".join(ast.unparse(node) for node in kept)


def _dispatchers(layout: Layout) -> str:
    """The functions of _terms.py for this layout."""
    slots = Slots(layout)
    setup = (constants, rows, queries, states, command, pace)
    motion = (torques, friction, output)
    return "\n\n".join(write(slots) for write in (*setup, *motion))
