"""What an effect's functions must be, checked when the effect is declared.

The compiled kernel holds a function's own lines and nothing else of its file, and calls it by
position. So a wrong argument or a global name would fail far from the line that causes it, or
compute something else. Here a declaration is checked as a whole, and its functions are called once.
"""

from __future__ import annotations

import ast
import inspect
import math
import textwrap
from collections.abc import Callable, Sequence
from typing import Any

from servosight.models.core import InputError, Parameter
from servosight.models.effects._place import Usage

Function = Callable[..., Any]

MODULES = ("math", "np")
"""Names of modules that the kernel has."""
BUILTINS = frozenset(
    "abs bool divmod enumerate float int len max min pow range round sum tuple zip".split()  # noqa: SIM905
)
"""Built-in functions that are compiled."""

_AT = {
    "T": 0.05,
    "acceleration": 3e3,
    "angle": 3.0,
    "disturbance": 2.0,
    "drive": 4.0,
    "far_theta": 2.9,
    "far_w": 25.0,
    "horizon": 1.0,
    "last": 3.0,
    "load": 1.0,
    "slope": 0.0,
    "speed": 30.0,
    "start": 2.0,
    "theta": 3.0,
    "value": 3.0,
    "w": 30.0,
}
"""Where the trial call takes each argument, in seconds, degrees and deg/s."""


def is_a(value: object, kind: type) -> bool:
    """True for a ``kind``; True and False are no numbers."""
    return isinstance(value, kind) and isinstance(value, bool) == (kind is bool)


def all_are(values: object, kind: type) -> bool:
    """True for a tuple of ``kind``, also an empty one."""
    return isinstance(values, tuple) and all(isinstance(one, kind) for one in values)


def check_function(
    name: str, function: Function, use: Usage, parameters: Sequence[Parameter]
) -> None:
    """Refuse a function that the kernel cannot call as ``use`` says, or that does something else.

    ``name`` begins each message: the effect, its place and the function's role.
    """
    check_arguments(name, function, use.leading, [one.name for one in parameters])
    check_names(name, function)
    arguments = [_AT.get(one, 0.0) for one in use.leading] + near_neutral(parameters)
    vanishes = None
    if use.vanishes is not None:
        vanishes = _AT[use.vanishes] if use.vanishes else 0.0
    _check_answer(name, function, arguments, use.answer, vanishes)


def parsed(name: str, function: Function) -> ast.FunctionDef:
    """The definition of a plain function; InputError where there is none to read."""
    try:
        node = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    except (OSError, TypeError, SyntaxError, IndexError):
        node = None
    if not isinstance(node, ast.FunctionDef):
        raise InputError(f"{name}: expected a plain function defined with def, in a file")
    return node


def check_arguments(
    name: str, function: Function, leading: Sequence[str], own: Sequence[str] = ()
) -> None:
    """Refuse a function that does not take ``leading`` and then ``own``, in this order.

    The leading arguments may have other names, but none of them another one's.
    """
    expected = [*leading, *own]
    arguments = list(inspect.signature(function).parameters.values())
    given = [one.name for one in arguments]
    plain = all(one.kind is inspect.Parameter.POSITIONAL_OR_KEYWORD for one in arguments)
    swapped = any(g != e and g in leading for g, e in zip(given, leading, strict=False))
    if not plain or swapped or len(given) != len(expected) or given[len(leading) :] != [*own]:
        raise InputError(
            f"{name} takes {_list(given)}, expected {_list(expected)}; rename, add or remove "
            f"arguments"
        )


def check_names(name: str, function: Function) -> None:
    """Refuse names that the kernel does not have: globals of the file, closures, other builtins."""
    definition = parsed(name, function)
    arguments = definition.args
    arguments.defaults = []
    for argument in arguments.args:
        argument.annotation = None
    nodes = [node for line in definition.body for node in ast.walk(line)]
    names = [node for node in nodes if isinstance(node, ast.Name)]
    own = {argument.arg for argument in arguments.args}
    own |= {node.id for node in names if isinstance(node.ctx, ast.Store)}
    for node in names:
        if node.id in own or node.id in MODULES or node.id in BUILTINS:
            continue
        raise InputError(
            f"{name} uses {node.id}, which the compiled kernel does not have; expected arguments, "
            f"local names, math and {', '.join(sorted(BUILTINS))}, so write the value itself or "
            f"make it a parameter"
        )


def near_neutral(parameters: Sequence[Parameter]) -> list[float]:
    """Values so close to the neutral ones that the effect nearly vanishes."""
    values = []
    for parameter in parameters:
        low, high, neutral = parameter.low, parameter.high, parameter.neutral
        if neutral is None:
            values.append(0.5 * (low + high))
        elif math.isinf(neutral):
            values.append(math.copysign(1e9 * max(abs(low), 1.0), neutral))
        else:
            away = 1e-9 * (high - low)
            values.append(neutral - away if neutral >= high else neutral + away)
    return values


def _check_answer(
    name: str,
    function: Function,
    arguments: Sequence[float],
    answer: Sequence[str],
    vanishes: float | None,
) -> None:
    """Call once; refuse anything but ``answer``, and what does not vanish at neutral."""
    try:
        found = function(*arguments)
    except ArithmeticError:  # where neutral divides by zero, as the kernel never does
        return
    except Exception as error:
        raise InputError(
            f"{name} fails near its neutral values ({type(error).__name__}: {error}); expected it "
            f"to return {_list(answer)}"
        ) from None
    numbers = found if isinstance(found, tuple) else (found,)
    if len(numbers) != len(answer) or not all(_is_number(one) for one in numbers):
        raise InputError(
            f"{name} returns {str(found)[:60]}, expected {_list(answer)}: "
            f"{'one number' if len(answer) == 1 else f'a tuple of {len(answer)} numbers'}"
        )
    if vanishes is None or abs(numbers[0] - vanishes) <= 1e-3 * (1.0 + abs(vanishes)):
        return
    raise InputError(
        f"{name} returns {numbers[0]:.6g} near its neutral values, expected {vanishes:.6g}, for an "
        f"effect vanishes there; correct the neutral values or the function"
    )


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not math.isnan(value)


def _list(names: Any) -> str:
    return f"({', '.join(names)})"
