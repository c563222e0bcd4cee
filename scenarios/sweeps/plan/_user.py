"""A function of the user's own that a cell calls, named by an entry point."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any

from servosight.models.core import InputError, did_you_mean

GROUP = "servosight.sweep"
"""Entry points of installed packages; beside them any ``module:function`` is accepted."""

UserFunction = Callable[..., Mapping[str, Any]]


def user_function(name: str, source: str) -> UserFunction:
    """The function that ``name`` stands for: ``module:function`` or an entry point of ``GROUP``.

    It is called with the recording and the scenario and gives columns by name: numbers, texts or
    None. Raises InputError where there is none.
    """
    if ":" in name:
        point = EntryPoint(name=name, value=name, group=GROUP)
    else:
        known = {one.name: one for one in entry_points(group=GROUP)}
        choices = ("identify", "diagnose", *known)
        if name not in known:
            raise InputError(
                f"{source}: key do is {name!r}, expected one of {', '.join(choices)} "
                f"or module:function{did_you_mean(name, choices)}; correct the name"
            )
        point = known[name]
    try:
        found = point.load()
    except (ImportError, AttributeError, ValueError) as error:
        raise InputError(
            f"{source}: key do is {name!r}, which cannot be imported ({error}), expected "
            f"module:function of an importable module; install it or set PYTHONPATH"
        ) from None
    if not callable(found):
        raise InputError(
            f"{source}: key do is {name!r}, which is no function, expected module:function; "
            f"correct the name"
        )
    return found  # type: ignore[no-any-return]


def digest_of(name: str, source: str) -> str:
    """A hash over the file of a user's function."""
    function = user_function(name, source)
    module = import_module(inspect.unwrap(function).__module__)
    file = getattr(module, "__file__", None)
    text = Path(file).read_bytes() if file else repr(function).encode()
    return hashlib.sha256(text).hexdigest()[:16]
