"""Values that stay as they were made: their arrays and mappings are read-only, too."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T")


class FrozenMapping(Mapping[str, T]):
    """A read-only copy of a mapping, which, unlike Python's own proxy, can be copied and pickled.

    >>> shares = FrozenMapping({"backlash": 1.0})
    >>> shares
    {'backlash': 1.0}
    >>> shares["backlash"] = 0.5
    Traceback (most recent call last):
    TypeError: 'FrozenMapping' object does not support item assignment
    """

    __slots__ = ("_items",)

    def __init__(self, items: Mapping[str, T]) -> None:
        self._items = dict(items)

    def __getitem__(self, name: str) -> T:
        return self._items[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __repr__(self) -> str:
        """As a dictionary's."""
        return repr(self._items)


class Frozen:
    """Base of a frozen dataclass whose fields that are arrays or mappings are read-only as well.

    An array is not copied: it is the given one, seen through a read-only view.

    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True)
    ... class Run(Frozen):
    ...     angle_deg: NDArray[np.float64]
    >>> Run(np.zeros(3)).angle_deg[0] = 1.0
    Traceback (most recent call last):
    ValueError: assignment destination is read-only
    """

    __dataclass_fields__: ClassVar[dict[str, Any]]

    def __post_init__(self) -> None:
        """Replace each array and each mapping by one that is read-only."""
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, np.ndarray) and value.flags.writeable:
                object.__setattr__(self, field.name, _read_only(value))
            elif isinstance(value, Mapping) and not isinstance(value, FrozenMapping):
                object.__setattr__(self, field.name, FrozenMapping(value))


def _read_only(values: NDArray[Any]) -> NDArray[Any]:
    seen = values.view()
    seen.flags.writeable = False
    return seen
