"""The methods, by the name that ``--method`` and ``TrackOptions.method`` take."""

from __future__ import annotations

import difflib

from servosight.models.core import InputError
from servosight.tracking.methods._contract import Method
from servosight.tracking.methods._marker import marker
from servosight.tracking.methods._match import match
from servosight.tracking.methods._refine import refine

METHODS: dict[str, Method] = {
    "refine": refine,
    "match": match,
    "marker": marker,
}


def method_of(name: str) -> Method:
    """The method of that name; ``InputError`` where there is none.

    >>> method_of("refine").__name__
    'refine'
    """
    if name in METHODS:
        return METHODS[name]
    near = difflib.get_close_matches(name, METHODS, 1)
    hint = f"did you mean {near[0]}?" if near else "name one of these."
    raise InputError(f"method {name!r} is not known; expected one of {', '.join(METHODS)}, {hint}")
