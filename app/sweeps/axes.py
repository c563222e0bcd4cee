"""A sweep's axes as a picture shows them: keys that change together are one axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from servosight.scenarios.sweeps import Summary, value_text

Rows = Sequence[Mapping[str, Any]]


@dataclass(frozen=True)
class Joint:
    """Keys that change together; ``values`` are their tuples, in order."""

    names: tuple[str, ...]
    values: tuple[tuple[Any, ...], ...]

    @property
    def label(self) -> str:
        """The names in words."""
        return ", ".join(self.names)

    def of(self, row: Mapping[str, Any]) -> tuple[Any, ...]:
        """The values of a row."""
        return tuple(row[name] for name in self.names)

    def texts(self) -> list[str]:
        """Each step, as a tick shows it."""
        return [", ".join(map(value_text, value)) for value in self.values]

    def numbers(self, table: Rows) -> list[float]:
        """The first key's value in each row; for a text its place among all."""
        if not isinstance(self.values[0][0], str):
            return [float(row[self.names[0]]) for row in table]
        place = {value: float(number) for number, value in enumerate(self.values)}
        return [place[self.of(row)] for row in table]


def joint_axes(found: Summary) -> list[Joint]:
    """A sweep's axes; one that rises or falls with an earlier one, step by step, joins it.

    Those of which there is one value as yet are left out, unless there are no others.
    """
    several = [name for name in found.axes if len({row[name] for row in found.table}) > 1]
    joined: list[tuple[str, ...]] = []
    for name in several or found.axes[:1]:
        for place, names in enumerate(joined):
            if _together(found.table, names[0], name):
                joined[place] = (*names, name)
                break
        else:
            joined.append((name,))
    return [
        Joint(names, tuple(sorted({tuple(row[n] for n in names) for row in found.table})))
        for names in joined
    ]


def _together(table: Rows, one: str, other: str) -> bool:
    """Whether each value of ``one`` has its own of ``other``, in rising or falling order."""
    pairs = sorted({(row[one], row[other]) for row in table})
    values = [value for _, value in pairs]
    steps = sorted(set(values))
    single = len(pairs) == len({first for first, _ in pairs}) == len(steps) > 1
    return single and values in (steps, steps[::-1])
