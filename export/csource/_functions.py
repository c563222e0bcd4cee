"""One function of the restricted Python as one function in C.

Its types are known (_inference.py). A tuple comes in by its address and goes out by value.
"""

from __future__ import annotations

import ast
import re
from dataclasses import dataclass, field

from servosight.export.csource._expressions import expression, truth
from servosight.export.csource._inference import Types, is_stored, read, spelled_out
from servosight.export.csource._types import (
    ARRAY,
    NOTHING,
    NUMBER,
    SCALARS,
    TRUTH,
    WHOLE,
    Tuple,
    Type,
)
from servosight.export.csource._values import NotInC, Value, number, safe


@dataclass
class Printer(Types):
    """Prints one function for given types of its arguments."""

    lines: list[str] = field(default_factory=list)
    declared: set[str] = field(default_factory=set)

    def text(self) -> str:
        """The function's definition in C."""
        self.scope.count = 0
        self.scope.ahead.clear()
        for name in self.copied:
            self.lines.append(
                f"    {self.structures.name(self.variables[name])} {safe(name)} = *{name}_in;"
            )
        top = len(self.lines)
        for statement in self.node.body:
            self._print(statement, 1)
        late = sorted(set(self.variables) - set(self.parameters) - self.loops - self.declared)
        self.lines[top:top] = [f"    {self._declaration(name)};" for name in late]
        names = [n for n in ast.walk(self.node) if isinstance(n, ast.Name)]
        used = {n.id for n in names if not is_stored(n)} | self.renewed()
        unread = sorted(set(self.variables) - used - self.loops - self.copied)
        voids = [f"    (void){safe(name)};" for name in unread]
        heads = [line for name in unread if name in self.parameters
                 for line in voids if line == f"    (void){safe(name)};"]  # fmt: skip
        tails = [line for line in voids if line not in heads]
        at = next((i for i, line in enumerate(self.lines) if line.startswith("    return")), None)
        at = len(self.lines) if at is None else at
        body = [*heads, *self.lines[:at], *tails, *self.lines[at:]]
        answer = self.structures.name(self.answer or NOTHING)
        taken = ", ".join(self._parameter(name) for name in self.parameters)
        return f"static {answer} {self.name}({taken})\n{{\n" + "\n".join(body) + "\n}\n"

    def _parameter(self, name: str) -> str:
        kind = self.parameters[name]
        if isinstance(kind, Tuple):
            called = f"{name}_in" if name in self.copied else safe(name)
            return f"const {self.structures.name(kind)} *{called}"
        if kind == ARRAY:
            constant = "" if self._changes(name) else "const "
            length = f", long {safe(name)}_length" if safe(name) in self.scope.lengths else ""
            return f"{constant}double *{safe(name)}{length}"
        return f"{kind} {safe(name)}"

    def _changes(self, name: str) -> bool:
        """True where an array is written to, or handed on."""
        for node in ast.walk(self.node):
            if isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Store):
                touched = [node.value]
            elif isinstance(node, ast.Call) and ast.unparse(node.func) != "len":
                touched = node.args
            else:
                continue
            if any(isinstance(one, ast.Name) and one.id == name for one in touched):
                return True
        return False

    def _declaration(self, name: str) -> str:
        kind = self.variables[name]
        start = {NUMBER: "0.0", WHOLE: "0", TRUTH: "false"}
        zero = start[kind] if isinstance(kind, str) else "{0}"
        return f"{self.structures.name(kind)} {safe(name)} = {zero}"

    def _put(self, depth: int, line: str) -> None:
        pad = "    " * depth
        self.lines += [f"{pad}{one}" for one in self.scope.ahead]
        self.scope.ahead.clear()
        self.lines.append(pad + line)

    def _print(self, node: ast.stmt, depth: int) -> None:
        if isinstance(node, ast.Assign):
            first, *others = node.targets
            self._assign(first, node.value, depth)
            for other in others:
                self._assign(other, read(first), depth)
        elif isinstance(node, ast.AugAssign):
            self._assign(node.target, spelled_out(node), depth)
        elif isinstance(node, ast.Return):
            assert self.answer is not None
            value = "" if node.value is None else " " + self._as(node.value, self.answer)
            self._put(depth, f"return{value};")
        elif isinstance(node, ast.If):
            self._branch(node, depth)
        elif isinstance(node, ast.While):
            test = truth(node.test, self.scope)
            if self.scope.ahead or node.orelse:
                raise NotInC(f"while {ast.unparse(node.test)[:40]}; expected a plain comparison")
            self._put(depth, f"while ({test}) {{")
            self._block(node.body, depth)
        elif isinstance(node, ast.For):
            self._loop(node, depth)
        elif isinstance(node, ast.Break | ast.Continue):
            self._put(depth, "break;" if isinstance(node, ast.Break) else "continue;")
        elif isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            self._put(depth, f"{expression(node.value, self.scope).text};")
        elif not isinstance(node, ast.Pass) and not _is_text(node):
            raise NotInC(f"{ast.unparse(node)[:40]}; expected assignments, if, for and while")

    def _block(self, body: list[ast.stmt], depth: int) -> None:
        for inner in body:
            self._print(inner, depth + 1)
        self.lines.append("    " * depth + "}")

    def _branch(self, node: ast.If, depth: int) -> None:
        self._put(depth, f"if ({_bare(truth(node.test, self.scope))}) {{")
        self._block(node.body, depth)
        if node.orelse:
            self.lines[-1] += " else {"
            self._block(node.orelse, depth)

    def _loop(self, node: ast.For, depth: int) -> None:
        call = node.iter
        if not (
            isinstance(call, ast.Call)
            and isinstance(call.func, ast.Name)
            and call.func.id == "range"
            and len(call.args) < 3
            and isinstance(node.target, ast.Name)
        ):
            raise NotInC(f"for ... in {ast.unparse(call)[:40]}; expected range(n) or range(a, b)")
        bounds = [number(expression(one, self.scope), WHOLE) for one in call.args]
        first, last = bounds if len(bounds) == 2 else ("0", bounds[0])
        name = f"turn{depth}_" if node.target.id == "_" else safe(node.target.id)
        self._put(depth, f"for (long {name} = {first}; {name} < {last}; ++{name}) {{")
        self._block(node.body, depth)

    def _assign(self, target: ast.expr, value: ast.expr, depth: int) -> None:
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            self._together(target, value, depth)
        elif isinstance(target, ast.Tuple):
            found = expression(value, self.scope)
            self._apart(target, self._held(found), depth)
        else:
            self._store(target, self._as(value, self._kind(target)), depth)

    def _together(self, target: ast.Tuple, value: ast.Tuple, depth: int) -> None:
        """``a, b = x, y``: through copies where a later value reads an earlier target."""
        stored = {n.id for n in ast.walk(target) if isinstance(n, ast.Name)}
        read = {n.id for one in value.elts for n in ast.walk(one) if isinstance(n, ast.Name)}
        pairs = list(zip(target.elts, value.elts, strict=True))
        if not stored & read:
            for one, new in pairs:
                self._assign(one, new, depth)
            return
        texts = [
            self.scope.temporary(self._kind(one), self._as(new, self._kind(one)))
            for one, new in pairs
        ]
        for (one, _), text in zip(pairs, texts, strict=True):
            self._store(one, text, depth)

    def _apart(self, target: ast.Tuple, value: Value, depth: int) -> None:
        """Each name of a target takes its item of a tuple."""
        assert isinstance(value.kind, Tuple)
        dot = f"{value.text[2:-1]}->" if value.text.startswith("(*") else f"{value.text}."
        for i, one in enumerate(target.elts):
            item = Value(f"{dot}{value.kind.item(i)}", value.kind.items[i], place=True)
            if isinstance(one, ast.Tuple):
                self._apart(one, item, depth)
            elif not (isinstance(one, ast.Name) and one.id == "_"):
                kind = self._kind(one)
                text = number(item, kind) if kind in SCALARS else item.text
                self._store(one, text, depth)

    def _held(self, value: Value) -> Value:
        if value.place:
            return value
        return Value(self.scope.temporary(value.kind, value.text), value.kind, place=True)

    def _kind(self, target: ast.expr) -> Type:
        if isinstance(target, ast.Subscript):
            return NUMBER
        assert isinstance(target, ast.Name)
        return self.variables[target.id]

    def _store(self, target: ast.expr, text: str, depth: int) -> None:
        text = _bare(text)
        if isinstance(target, ast.Name):
            new = target.id not in self.declared | set(self.parameters)
            if depth == 1 and new and not self._seen(target.id):
                self.declared.add(target.id)
                kind = self.structures.name(self.variables[target.id])
                self._put(depth, f"{kind} {safe(target.id)} = {text};")
            else:
                self._put(depth, f"{safe(target.id)} = {text};")
        else:
            self._put(depth, f"{expression(target, self.scope).text} = {text};")

    def _seen(self, name: str) -> bool:
        """True where a line so far names a variable that is not declared at its place."""
        return any(re.search(rf"\b{safe(name)}\b", line) for line in self.lines)

    def _as(self, node: ast.expr, kind: Type) -> str:
        """An expression as a value of ``kind``."""
        if isinstance(node, ast.Tuple) and isinstance(kind, Tuple):
            inner = ", ".join(
                self._as(one, item) for one, item in zip(node.elts, kind.items, strict=True)
            )
            braces = f"{{{{{inner}}}}}" if kind.same else f"{{{inner}}}"
            return f"({self.structures.name(kind)}){braces}"
        value = expression(node, self.scope)
        return number(value, kind) if kind in (NUMBER, WHOLE) else value.text


def _bare(text: str) -> str:
    """Without the brackets round the whole, which a statement does not need."""
    if not (text.startswith("(") and text.endswith(")")):
        return text
    depth = 0
    for i, letter in enumerate(text):
        depth += (letter == "(") - (letter == ")")
        if depth == 0 and i < len(text) - 1:
            return text
    return text[1:-1]


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
