"""Values in C: their text and type, the names and constants that C takes, what a scope knows."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from servosight.export.csource._types import NUMBER, TRUTH, WHOLE, Structures, Type

MATH = {
    name: name
    for name in (
        *("acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "ceil", "copysign", "cos"),
        *("cosh", "erf", "erfc", "exp", "expm1", "fabs", "floor", "fmod", "hypot", "log", "log10"),
        *("log1p", "log2", "pow", "sin", "sinh", "sqrt", "tan", "tanh", "trunc"),
    )
} | {"arctan2": "atan2", "arcsin": "asin", "arccos": "acos", "arctan": "atan", "abs": "fabs"}
"""Functions of math and numpy that C has, by their name there."""
_TAKEN = frozenset(
    (
        *("auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else"),
        *("enum", "extern", "float", "for", "goto", "if", "inline", "int", "long", "register"),
        *("restrict", "return", "short", "signed", "sizeof", "static", "struct", "switch"),
        *("typedef", "union", "unsigned", "void", "volatile", "while", "bool", "true", "false"),
        *("near", "far", "fmin", "fmax", "fabs", "main"),
        *MATH.values(),
    )
)


class NotInC(Exception):
    """What the restricted Python does not have; the message says what and what instead."""


@dataclass(frozen=True)
class Value:
    """An expression in C: its text, its type, and whether it names a place in memory."""

    text: str
    kind: Type
    place: bool = False


@dataclass
class Scope:
    """What an expression may read: variables, constants, functions; and what goes ahead of it."""

    structures: Structures
    variables: dict[str, Type]
    pointers: set[str]  # parameters that are tuples, which come as pointers
    constant: Callable[[str], Any]
    call: Callable[[str, list[Type]], tuple[str, list[Type], Type]]
    ahead: list[str] = field(default_factory=list)
    lengths: set[str] = field(default_factory=set)
    count: int = 0

    def temporary(self, kind: Type, text: str) -> str:
        """A new local constant that holds the value of ``text``."""
        self.count += 1
        name = f"t{self.count}_"
        self.ahead.append(f"const {self.structures.name(kind)} {name} = {text};")
        return name


def safe(name: str) -> str:
    """A name that C and its mathematics leave free."""
    return f"{name}_" if name in _TAKEN else name


def literal(value: Any) -> Value:
    """A constant as C."""
    if isinstance(value, bool):
        return Value("true" if value else "false", TRUTH)
    if isinstance(value, int):
        return Value(str(value), WHOLE)
    if isinstance(value, float):
        if math.isnan(value):
            return Value("NAN", NUMBER)
        if math.isinf(value):
            return Value("INFINITY" if value > 0 else "(-INFINITY)", NUMBER)
        return Value(repr(value), NUMBER)
    raise NotInC(f"the constant {value!r}; expected numbers")


def number(value: Value, kind: Type = NUMBER) -> str:
    """The text of a value, cast to a scalar type where it has another."""
    if value.kind == kind:
        return value.text
    if kind == NUMBER and value.kind == WHOLE:
        bare = value.text.lstrip("(-").rstrip(")").isdigit()
        return f"{value.text}.0" if value.text.isdigit() else (
            f"({value.text.strip('()')}.0)" if bare else f"(double)({value.text})"
        )  # fmt: skip
    raise NotInC("a truth value or a tuple where a number belongs")
