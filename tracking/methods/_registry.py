"""The methods, by the name that ``--method`` and ``TrackOptions.method`` take."""

from __future__ import annotations

from importlib import import_module

from servosight.models.core import InputError, did_you_mean
from servosight.tracking.method_names import METHOD_WORDS
from servosight.tracking.methods._contract import Method

METHODS: dict[str, Method] = {
    name: getattr(import_module(f"servosight.tracking.methods._{name}"), name)
    for name in METHOD_WORDS
}


def method_of(name: str) -> Method:
    """The method of that name; ``InputError`` where there is none.

    >>> method_of("refine").__name__
    'refine'
    """
    if name in METHODS:
        return METHODS[name]
    raise InputError(
        f"method {name!r} is not known{did_you_mean(name, METHODS)}; expected one of "
        f"{', '.join(METHODS)}"
    )
