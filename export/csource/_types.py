"""Types of the restricted Python of the plant kernel, and how C says them.

Scalars are numbers, whole numbers and truth values; an array is a pointer. A tuple is a structure:
of one array ``v`` where all its items are scalars of one kind, else of fields ``f0``, ``f1``, ...
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TypeAlias

NUMBER = "double"
WHOLE = "long"
TRUTH = "bool"
ARRAY = "double *"
NOTHING = "void"
SCALARS = (NUMBER, WHOLE, TRUTH)


@dataclass(frozen=True)
class Tuple:
    """The type of a tuple, by the types of its items."""

    items: tuple[Type, ...]

    @property
    def same(self) -> bool:
        """True where all items are scalars of one kind, so that an index may vary."""
        return len(set(self.items)) == 1 and self.items[0] in SCALARS

    def item(self, index: int) -> str:
        """How C reaches an item behind a point or an arrow."""
        return f"v[{index}]" if self.same else f"f{index}"


Type: TypeAlias = str | Tuple


def joined(a: Type, b: Type) -> Type:
    """The type that holds values of both; ValueError where there is none."""
    if a == b:
        return a
    if isinstance(a, Tuple) and isinstance(b, Tuple) and len(a.items) == len(b.items):
        return Tuple(tuple(joined(x, y) for x, y in zip(a.items, b.items, strict=True)))
    if {a, b} == {NUMBER, WHOLE}:
        return NUMBER
    raise ValueError(f"a value is {said(a)} in one place and {said(b)} in another")


def said(kind: Type) -> str:
    """The type in words, for a message."""
    if isinstance(kind, Tuple):
        return f"a tuple of {len(kind.items)}"
    words = {NUMBER: "a number", WHOLE: "a whole number", TRUTH: "true or false"}
    return words.get(kind, "an array" if kind == ARRAY else "nothing")


@dataclass
class Structures:
    """The structures that a program needs, in the order in which C must see them."""

    prefix: str
    names: dict[Tuple, str] = field(default_factory=dict)

    def name(self, kind: Type) -> str:
        """How C writes a type; a tuple's structure is noted."""
        if not isinstance(kind, Tuple):
            return kind
        if kind not in self.names:
            for item in kind.items:
                self.name(item)
            plural = {NUMBER: "doubles", WHOLE: "longs", TRUTH: "bools"}
            if kind.same and isinstance(kind.items[0], str):
                name = f"{self.prefix}_{plural[kind.items[0]]}_{len(kind.items)}"
            else:
                name = f"{self.prefix}_tuple_{sum(not one.same for one in self.names) + 1}"
            self.names[kind] = name
        return self.names[kind]

    def definitions(self) -> Iterable[str]:
        """The structures as C."""
        for kind, name in self.names.items():
            if kind.same:
                fields = f"    {kind.items[0]} v[{len(kind.items)}];"
            else:
                fields = "\n".join(
                    f"    {self.name(item)} f{i};" for i, item in enumerate(kind.items)
                )
            yield f"typedef struct {{\n{fields}\n}} {name};"
