"""The functions of a plant kernel that a caller needs, as C.

The text is the one that numba compiles (:func:`servosight.models.plant.kernel_source`): effects,
dispatch, linear core and integrator alike. Nothing of the physics is written a second time.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from servosight.export.csource._functions import Printer
from servosight.export.csource._types import NOTHING, NUMBER, Structures, Tuple, Type
from servosight.export.csource._values import NotInC, safe
from servosight.models.core import InputError

_HELPERS = {
    "min2": "static double min2(double a, double b)\n{\n    return b < a ? b : a;\n}\n",
    "max2": "static double max2(double a, double b)\n{\n    return b > a ? b : a;\n}\n",
}


@dataclass
class Program:
    """Functions printed on demand, each ahead of those that call it."""

    kernel: str
    prefix: str
    structures: Structures = field(init=False)
    texts: list[str] = field(default_factory=list)
    done: dict[tuple[str, tuple[Type, ...]], tuple[str, Type]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Read the kernel's functions and constants."""
        self.structures = Structures(self.prefix)
        tree = ast.parse(self.kernel)
        self.functions = {one.name: one for one in tree.body if isinstance(one, ast.FunctionDef)}
        plain = [one for one in tree.body if isinstance(one, ast.Assign)]
        self.constants: dict[str, Any] = {"math": math}
        for one in plain:
            if ast.unparse(one.targets[0]) != "njit":
                exec(compile(ast.Module([one], []), "kernel", "exec"), self.constants)
        self.arrays: dict[str, str] = {}

    def need(self, name: str, kinds: Sequence[Type]) -> Type:
        """Print a function, and all that it calls, for arguments of these types."""
        return self._call(name, list(kinds))[2]

    def text(self) -> str:
        """All functions so far."""
        return "\n".join([*self.arrays.values(), *self.texts])

    def _call(self, name: str, kinds: list[Type]) -> tuple[str, list[Type], Type]:
        key = (name, tuple(kinds))
        if key not in self.done:
            self.done[key] = self._print(name, kinds)
        function, answer = self.done[key]
        return function, kinds, answer

    def _print(self, name: str, kinds: list[Type]) -> tuple[str, Type]:
        if name in _HELPERS:
            self.texts.append(_HELPERS[name])
            return name, NUMBER
        if name not in self.functions:
            raise NotInC(f"{name}(); expected arithmetic, functions of math, abs, min and max")
        others = sum(known == name for known, _ in self.done)
        called = safe(name) + (f"_{others + 1}" if others else "")
        try:
            printer = Printer(
                self.functions[name], called, kinds, self.structures, self._constant, self._call
            )
            self.texts.append(printer.text())
        except (NotInC, ValueError) as error:
            effect, _, role = name.partition("__")
            if not role:
                raise
            raise InputError(
                f"effect {effect}: {role} cannot be written as C, for it has {error}"
            ) from None
        return called, printer.answer or NOTHING

    def _constant(self, name: str) -> Any:
        if name not in self.constants:
            raise NotInC(f"the name {name}; expected arguments and local names")
        value = self.constants[name]
        if isinstance(value, tuple):
            kind = Tuple((NUMBER,) * len(value))
            numbers = ", ".join(repr(float(one)) for one in value)
            self.arrays[name] = (
                f"static const {self.structures.name(kind)} {self.prefix}{name} = "
                f"{{{{{numbers}}}}};\n"
            )
        return value
