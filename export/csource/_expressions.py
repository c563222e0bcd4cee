"""Expressions of the restricted Python as C, with their types.

What a tuple-valued call returns goes into a local variable of its own ahead of the statement. The
functions have no effects but on arrays, so an earlier evaluation changes nothing.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable
from typing import Any

from servosight.export.csource._types import (
    ARRAY,
    NUMBER,
    SCALARS,
    TRUTH,
    WHOLE,
    Tuple,
    Type,
    joined,
)
from servosight.export.csource._values import MATH, NotInC, Scope, Value, literal, number, safe

_TESTS = ("isinf", "isnan", "isfinite")
_CONSTANTS = {"inf": math.inf, "pi": math.pi, "e": math.e, "tau": math.tau, "nan": math.nan}
_COMPARED = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
_JOINED = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}


def expression(node: ast.expr, scope: Scope) -> Value:
    """An expression as C."""
    handler = _HANDLERS.get(type(node))
    if handler is None:
        raise NotInC(f"{ast.unparse(node)[:40]}; expected arithmetic on numbers and if")
    return handler(node, scope)


def truth(node: ast.expr, scope: Scope) -> str:
    """A condition as C."""
    value = expression(node, scope)
    if value.kind != TRUTH:
        raise NotInC(f"{ast.unparse(node)[:40]} as a condition; expected a comparison")
    return value.text


def _name(node: ast.Name, scope: Scope) -> Value:
    if node.id in scope.variables:
        kind = scope.variables[node.id]
        text = f"(*{safe(node.id)})" if node.id in scope.pointers else safe(node.id)
        return Value(text, kind, place=True)
    found = scope.constant(node.id)
    if isinstance(found, tuple):
        kind = Tuple((NUMBER,) * len(found))
        return Value(f"{scope.structures.prefix}{node.id}", kind, place=True)
    return literal(found)


def _attribute(node: ast.Attribute, scope: Scope) -> Value:
    if isinstance(node.value, ast.Name) and node.attr in _CONSTANTS:
        return literal(_CONSTANTS[node.attr])
    raise NotInC(f"{ast.unparse(node)}; expected a function or constant of math")


def _tuple(node: ast.Tuple, scope: Scope) -> Value:
    values = [expression(item, scope) for item in node.elts]
    kind = Tuple(tuple(value.kind for value in values))
    inner = ", ".join(value.text for value in values)
    braces = f"{{{{{inner}}}}}" if kind.same else f"{{{inner}}}"
    return Value(f"({scope.structures.name(kind)}){braces}", kind)


def _subscript(node: ast.Subscript, scope: Scope) -> Value:
    base = expression(node.value, scope)
    if base.kind == ARRAY:
        index = expression(node.slice, scope)
        return Value(f"{base.text}[{number(index, WHOLE)}]", NUMBER, place=True)
    if not isinstance(base.kind, Tuple):
        raise NotInC(f"{ast.unparse(node)[:40]}; expected an index of a tuple")
    at = base.text if base.place else scope.temporary(base.kind, base.text)
    dot = f"{at[2:-1]}->" if at.startswith("(*") else f"{at}."
    if isinstance(node.slice, ast.Constant) and isinstance(node.slice.value, int):
        index_ = node.slice.value % len(base.kind.items)
        return Value(f"{dot}{base.kind.item(index_)}", base.kind.items[index_], place=True)
    if not base.kind.same:
        raise NotInC(f"{ast.unparse(node)[:40]}; expected a constant index")
    index = expression(node.slice, scope)
    return Value(f"{dot}v[{number(index, WHOLE)}]", base.kind.items[0], place=True)


def _negative(node: ast.UnaryOp, scope: Scope) -> Value:
    value = expression(node.operand, scope)
    if isinstance(node.op, ast.Not):
        return Value(f"(!{truth(node.operand, scope)})", TRUTH)
    if isinstance(node.op, ast.UAdd):
        return value
    if not isinstance(node.op, ast.USub) or value.kind not in (NUMBER, WHOLE):
        raise NotInC(f"{ast.unparse(node)[:40]}; expected a number")
    return Value(f"(-{value.text})", value.kind)


def _operation(node: ast.BinOp, scope: Scope) -> Value:
    left, right = expression(node.left, scope), expression(node.right, scope)
    symbol = _JOINED.get(type(node.op))
    if symbol is not None:
        whole = left.kind == right.kind == WHOLE and symbol != "/"
        kind = WHOLE if whole else NUMBER
        return Value(f"({number(left, kind)} {symbol} {number(right, kind)})", kind)
    a, b = number(left), number(right)
    if isinstance(node.op, ast.Pow):
        if right.kind == WHOLE and right.text == "2":
            held = left.text if left.place else scope.temporary(NUMBER, a)
            return Value(f"({held} * {held})", NUMBER)
        return Value(f"pow({a}, {b})", NUMBER)
    x, y = scope.temporary(NUMBER, a), scope.temporary(NUMBER, b)
    if isinstance(node.op, ast.Mod):
        return Value(f"({x} - {y} * floor({x} / {y}))", NUMBER)
    if isinstance(node.op, ast.FloorDiv):
        return Value(f"floor({x} / {y})", NUMBER)
    raise NotInC(f"{ast.unparse(node)[:40]}; expected +, -, *, /, //, % and **")


def _comparison(node: ast.Compare, scope: Scope) -> Value:
    values = [expression(item, scope) for item in (node.left, *node.comparators)]
    parts = []
    for a, op, b in zip(values, node.ops, values[1:], strict=False):
        symbol = _COMPARED.get(type(op))
        if symbol is None:
            raise NotInC(f"{ast.unparse(node)[:40]}; expected <, <=, >, >=, == and !=")
        kind = joined(a.kind, b.kind)
        if kind not in SCALARS:
            raise NotInC(f"{ast.unparse(node)[:40]}; expected numbers on both sides")
        parts.append(f"({number(a, kind)} {symbol} {number(b, kind)})")
    return Value(parts[0] if len(parts) == 1 else f"({' && '.join(parts)})", TRUTH)


def _connected(node: ast.BoolOp, scope: Scope) -> Value:
    word = " && " if isinstance(node.op, ast.And) else " || "
    return Value(f"({word.join(truth(one, scope) for one in node.values)})", TRUTH)


def _choice(node: ast.IfExp, scope: Scope) -> Value:
    test = truth(node.test, scope)
    yes, no = expression(node.body, scope), expression(node.orelse, scope)
    kind = joined(yes.kind, no.kind)
    if kind in (NUMBER, WHOLE):
        return Value(f"({test} ? {number(yes, kind)} : {number(no, kind)})", kind)
    return Value(f"({test} ? {yes.text} : {no.text})", kind)


def _call(node: ast.Call, scope: Scope) -> Value:
    if node.keywords or any(isinstance(one, ast.Starred) for one in node.args):
        raise NotInC(f"{ast.unparse(node)[:40]}; expected a call with plain arguments")
    if isinstance(node.func, ast.Attribute):
        return _mathematics(node.func.attr, node, scope)
    assert isinstance(node.func, ast.Name)
    name = node.func.id
    if name == "len":
        return _length(node, scope)
    values = [expression(one, scope) for one in node.args]
    if name in ("min", "max") and len(values) > 1:
        return _extreme(name, values, scope)
    if name == "abs" and values[0].kind == NUMBER:
        return Value(f"fabs({values[0].text})", NUMBER)
    if name == "float":
        return Value(number(values[0]), NUMBER)
    if name == "int":
        return Value(f"(long)({values[0].text})", WHOLE)
    if name == "bool" and values[0].kind == TRUTH:
        return values[0]
    function, kinds, answer = scope.call(name, [value.kind for value in values])
    given = [_argument(value, kind, scope) for value, kind in zip(values, kinds, strict=True)]
    return Value(f"{function}({', '.join(given)})", answer)


def _argument(value: Value, kind: Type, scope: Scope) -> str:
    """An argument: a scalar as it is, a tuple by its address."""
    if not isinstance(kind, Tuple):
        return value.text if kind == ARRAY else number(value, kind)
    if value.place:
        return value.text[2:-1] if value.text.startswith("(*") else f"&{value.text}"
    return f"&{scope.temporary(value.kind, value.text)}"


def _mathematics(name: str, node: ast.Call, scope: Scope) -> Value:
    given = [number(expression(one, scope)) for one in node.args]
    if name in _TESTS:
        return Value(f"({name}({given[0]}) != 0)", TRUTH)
    if name not in MATH:
        raise NotInC(f"{ast.unparse(node.func)}; expected one of {', '.join(sorted(MATH))}")
    return Value(f"{MATH[name]}({', '.join(given)})", NUMBER)


def _extreme(name: str, values: list[Value], scope: Scope) -> Value:
    """As Python has it: the first unless another is less, or more."""
    kind: Type = values[0].kind
    for value in values[1:]:
        kind = joined(kind, value.kind)
    found = number(values[0], kind)
    for value in values[1:]:
        function, _, _ = scope.call(f"{name}2", [NUMBER, NUMBER])
        found = f"{function}({found}, {number(value, kind)})"
    if kind != NUMBER:
        raise NotInC(f"{name} of whole numbers; write them as 1.0")
    return Value(found, NUMBER)


def _length(node: ast.Call, scope: Scope) -> Value:
    value = expression(node.args[0], scope)
    if isinstance(value.kind, Tuple):
        return Value(str(len(value.kind.items)), WHOLE)
    scope.lengths.add(value.text)
    return Value(f"{value.text}_length", WHOLE)


_HANDLERS: dict[type[ast.expr], Callable[[Any, Scope], Value]] = {
    ast.Constant: lambda node, scope: literal(node.value),
    ast.Name: _name,
    ast.Attribute: _attribute,
    ast.Tuple: _tuple,
    ast.Subscript: _subscript,
    ast.UnaryOp: _negative,
    ast.BinOp: _operation,
    ast.Compare: _comparison,
    ast.BoolOp: _connected,
    ast.IfExp: _choice,
    ast.Call: _call,
}
