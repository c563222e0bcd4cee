"""The types of the variables of one function of the restricted Python.

A local variable has the type that holds all values assigned to it.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from servosight.export.csource._expressions import expression
from servosight.export.csource._types import NOTHING, WHOLE, Structures, Tuple, Type, joined
from servosight.export.csource._values import NotInC, Scope

Caller = Callable[[str, list[Type]], tuple[str, list[Type], Type]]


@dataclass
class Types:
    """One function, and the types of its variables for given types of its arguments."""

    node: ast.FunctionDef
    name: str
    arguments: Sequence[Type]
    structures: Structures
    constant: Callable[[str], Any]
    call: Caller
    answer: Type | None = None
    variables: dict[str, Type] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Read the types off, statement after statement, until none widens."""
        names = [one.arg for one in self.node.args.args]
        if len(names) != len(self.arguments):
            raise NotInC(f"a call of {self.node.name} with {len(self.arguments)} arguments")
        self.parameters = dict(zip(names, self.arguments, strict=True))
        self.variables = dict(self.parameters)
        self.loops: set[str] = set()
        stored = {n.id for n in ast.walk(self.node) if isinstance(n, ast.Name) and is_stored(n)}
        self.pointers = {
            name for name, kind in self.parameters.items() if isinstance(kind, Tuple)
        } - stored
        self.copied = {
            name for name, kind in self.parameters.items() if isinstance(kind, Tuple)
        } & stored
        self.scope = self._scope()
        for _ in range(4):
            known = dict(self.variables)
            for statement in self.node.body:
                self._infer(statement)
            if known == self.variables:
                break

    def _scope(self) -> Scope:
        return Scope(self.structures, self.variables, self.pointers, self.constant, self.call)

    def renewed(self) -> set[str]:
        """Names of variables that ``+=`` and its like read and assign."""
        found = [n.target for n in ast.walk(self.node) if isinstance(n, ast.AugAssign)]
        return {target.id for target in found if isinstance(target, ast.Name)}

    def _infer(self, node: ast.stmt) -> None:
        if isinstance(node, ast.Assign):
            kind = expression(node.value, self.scope).kind
            for target in node.targets:
                self._note(target, kind)
        elif isinstance(node, ast.AugAssign):
            self._note(node.target, expression(spelled_out(node), self.scope).kind)
        elif isinstance(node, ast.Return):
            found: Type = NOTHING
            if node.value is not None:
                found = expression(node.value, self.scope).kind
            self.answer = found if self.answer is None else joined(self.answer, found)
        elif isinstance(node, ast.For) and isinstance(node.target, ast.Name):
            self.variables[node.target.id] = WHOLE
            self.loops.add(node.target.id)
        for block in ("body", "orelse"):
            for inner in getattr(node, block, []):
                self._infer(inner)

    def _note(self, target: ast.expr, kind: Type) -> None:
        if isinstance(target, ast.Tuple):
            if not isinstance(kind, Tuple) or len(kind.items) != len(target.elts):
                raise NotInC(f"{ast.unparse(target)[:40]} = something of another length")
            for item, one in zip(target.elts, kind.items, strict=True):
                self._note(item, one)
        elif isinstance(target, ast.Name) and target.id != "_":
            known = self.variables.get(target.id)
            self.variables[target.id] = kind if known is None else joined(known, kind)


def spelled_out(node: ast.AugAssign) -> ast.BinOp:
    """``a += b`` as a + b."""
    return ast.BinOp(read(node.target), node.op, node.value)


def read(target: ast.expr) -> ast.expr:
    """A target as an expression."""
    return ast.parse(ast.unparse(target), mode="eval").body


def is_stored(node: ast.Name) -> bool:
    """True where the name is assigned to."""
    return isinstance(node.ctx, ast.Store)
