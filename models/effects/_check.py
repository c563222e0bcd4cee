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
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from servosight.models.core import InputError, Parameter
from servosight.models.effects._place import Usage

Function = Callable[..., Any]

MODULES = ("math", "np")
"""Names of modules that the kernel has."""
BUILTINS = frozenset(
    "abs bool divmod enumerate float int len max min pow range round sum tuple zip".split()  # noqa: SIM905
)
"""Built-in functions that are compiled."""
_REFUSED = (
    ast.Global,
    ast.Nonlocal,
    ast.Import,
    ast.ImportFrom,
    ast.FunctionDef,
    ast.AsyncFunctionDef,
    ast.ClassDef,
    ast.Lambda,
    ast.With,
    ast.Try,
    ast.Raise,
    ast.Delete,
    ast.Yield,
    ast.YieldFrom,
    ast.Await,
)
"""What a function of numbers needs not, and what is not compiled or has an effect elsewhere."""

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
    "missing": 2.0,
    "slope": 0.0,
    "speed": 30.0,
    "start": 2.0,
    "theta": 3.0,
    "value": 3.0,
    "w": 30.0,
}
"""Where the trial calls take each argument, in seconds, degrees and deg/s."""
_LEAST = {"horizon": 0.0, "magnitude": 0.0, "seconds": 0.0}
"""The least value of what a function returns, by name."""


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
    leading = [_AT.get(one, 0.0) for one in use.leading]
    vanishes = None
    if use.vanishes is not None:
        vanishes = _AT[use.vanishes] if use.vanishes else 0.0
    _check_answer(name, function, [*leading, *near_neutral(parameters)], use, vanishes)
    _check_answer(name, function, [*leading, *between_bounds(parameters)], use)


def check_guesses(
    name: str, guesses: object, parameters: Sequence[Parameter]
) -> tuple[tuple[float, ...], ...]:
    """The initial guesses as they are; InputError unless each has a number for each parameter."""
    names = [one.name for one in parameters]
    right = isinstance(guesses, tuple | list) and all(
        isinstance(one, tuple | list) and len(one) == len(names) and all(map(_is_finite, one))
        for one in guesses
    )
    if not right:
        raise InputError(
            f"{name} returns {str(guesses)[:60]}, expected a tuple of guesses, each a tuple of "
            f"finite numbers for {_list(names)}"
        )
    return tuple(tuple(one) for one in guesses)  # type: ignore[attr-defined]


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

    The leading arguments may have other names, but none of them another one's; none has a default.
    """
    expected = [*leading, *own]
    arguments = list(inspect.signature(function).parameters.values())
    given = [one.name for one in arguments]
    plain = all(
        one.kind is inspect.Parameter.POSITIONAL_OR_KEYWORD and one.default is one.empty
        for one in arguments
    )
    swapped = any(g != e and g in leading for g, e in zip(given, leading, strict=False))
    if not plain or swapped or len(given) != len(expected) or given[len(leading) :] != [*own]:
        raise InputError(
            f"{name} takes {_list(map(_shown, arguments))}, expected {_list(expected)}; rename, "
            f"add or remove arguments"
        )


def check_names(name: str, function: Function) -> None:
    """Refuse names that the kernel does not have: globals of the file, closures, other builtins."""
    definition = parsed(name, function)
    for node in (inner for line in definition.body for inner in ast.walk(line)):
        if isinstance(node, _REFUSED):
            raise InputError(
                f"{name} has the line `{ast.unparse(node).splitlines()[0]}`, which the compiled "
                f"kernel cannot hold; expected assignments, if, for, while and return"
            )
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


def between_bounds(parameters: Sequence[Parameter]) -> list[float]:
    """Values well within the bounds, at which the effect acts."""
    values = []
    for parameter in parameters:
        low, high = parameter.search_bounds
        values.append(parameter.from_search(0.75 * low + 0.25 * high))
    return values


def _check_answer(
    name: str,
    function: Function,
    arguments: Sequence[float],
    use: Usage,
    vanishes: float | None = None,
) -> None:
    """Call once; refuse anything but the answer, and what does not vanish at neutral."""
    answer = use.answer
    called = f"{name} at ({', '.join(f'{one:.6g}' for one in arguments)})"
    try:
        found = function(*arguments)
    except ArithmeticError:  # where neutral divides by zero, as the kernel never does
        return
    except Exception as error:
        raise InputError(
            f"{called} fails ({type(error).__name__}: {error}); expected it to return "
            f"{_list(answer)}"
        ) from None
    numbers = found if isinstance(found, tuple) else (found,)
    if len(numbers) != len(answer) or not all(_is_number(one) for one in numbers):
        raise InputError(
            f"{called} returns {str(found)[:60]}, expected {_list(answer)}: "
            f"{'one number' if len(answer) == 1 else f'a tuple of {len(answer)} numbers'}"
        )
    for one, number in zip(answer, numbers, strict=True):
        if number < _LEAST.get(one, -math.inf):
            raise InputError(
                f"{called} returns {number:.6g} as its {one}, expected at least {_LEAST[one]:g}"
            )
    if vanishes is None or abs(numbers[0] - vanishes) <= 1e-3 * (1.0 + abs(vanishes)):
        return
    raise InputError(
        f"{name} returns {numbers[0]:.6g} near its neutral values, expected {vanishes:.6g}, "
        f"since an effect vanishes there; correct the neutral values or the function"
    )


def _is_number(value: Any) -> bool:
    """True for a number; an infinite one may be a horizon or a longest step."""
    number = isinstance(value, int | float | np.integer | np.floating)
    return number and not isinstance(value, bool) and not math.isnan(value)


def _is_finite(value: Any) -> bool:
    return _is_number(value) and not math.isinf(value)


def _shown(argument: inspect.Parameter) -> str:
    """An argument without its annotation, as in ``*rest`` or ``size=2.0``."""
    return str(argument.replace(annotation=argument.empty))


def _list(names: Iterable[object]) -> str:
    return f"({', '.join(map(str, names))})"
