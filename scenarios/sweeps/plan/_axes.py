"""Axes of a sweep: lists, ranges, and points drawn at random or as a Latin hypercube.

An axis is a name, or several joined by commas that change together, and its values. Drawn axes
share one set of points: the i-th point takes the i-th value of each.
"""

from __future__ import annotations

import hashlib
import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from msgspec import Meta

from servosight.models.core import InputError, require, validated, validated_value

Setting = float | int | str | bool
Settings = Mapping[str, Setting]

SCALES = ("linear", "log")
DRAWS = ("latin", "random")
MOST_VALUES = 1_000_000
_FIX = 'write a list, or a range such as { from = 15, to = 240, steps = 5, scale = "log" }'


@dataclass(frozen=True)
class RangeKeys:
    """What a range may say beside ``from`` and ``to``."""

    steps: Annotated[int, Meta(ge=2, le=MOST_VALUES, description="a whole number from 2")] = 0
    scale: str = "linear"
    draw: str = ""


@dataclass(frozen=True)
class Axis:
    """Keys that change together, and their values, one tuple for each step."""

    names: tuple[str, ...]
    values: tuple[tuple[Setting, ...], ...]

    def steps(self) -> Iterator[dict[str, Setting]]:
        """The settings of each step."""
        return (dict(zip(self.names, value, strict=True)) for value in self.values)


@dataclass(frozen=True)
class Design:
    """All axes: ``grid`` ones are combined each with each, and with every one of ``points``."""

    grid: tuple[Axis, ...]
    points: Axis | None

    @property
    def names(self) -> tuple[str, ...]:
        """The keys that change, in the order of the file, drawn ones last."""
        axes = (*self.grid, self.points) if self.points else self.grid
        return tuple(name for axis in axes for name in axis.names)

    @property
    def size(self) -> int:
        """How many combinations there are."""
        axes = (*self.grid, self.points) if self.points else self.grid
        return math.prod(len(axis.values) for axis in axes)

    def settings(self) -> Iterator[dict[str, Setting]]:
        """Every combination, made when it is asked for."""
        axes = (*self.grid, self.points) if self.points else self.grid
        names = self.names
        for parts in itertools.product(*(axis.values for axis in axes)):
            yield dict(zip(names, itertools.chain(*parts), strict=True))


def read_axes(table: Mapping[str, Any], points: int, whole: set[str], source: str) -> Design:
    """Read ``[axes]``; ``points`` is how many are drawn, ``whole`` the keys of whole numbers.

    Raises InputError, which names the axis, what was expected and how to correct it.
    """
    grid: list[Axis] = []
    drawn: dict[str, tuple[Setting, ...]] = {}
    seen: set[str] = set()
    for key, value in table.items():
        names = tuple(name.strip() for name in key.split(","))
        for name in names:
            once = bool(name) and name not in seen
            require(once, source, f"axes.{key}", name, "the name of a key, once in all axes")
            seen.add(name)
        if isinstance(value, Mapping):
            keys, low, high = _range(value, source, key, names)
            if keys.draw:
                drawn[key] = _rounded(key, _drawn(key, keys, low, high, points, source), whole)
            else:
                grid.append(_ranged(key, keys, low, high, whole, source))
        else:
            grid.append(_listed(key, names, value, source))
    if points and not drawn:
        raise InputError(
            f"{source}: key points is {points}, expected an axis that is drawn; add "
            f'draw = "latin" to an axis or remove points'
        )
    every = tuple(zip(*drawn.values(), strict=True))
    return Design(tuple(grid), Axis(tuple(drawn), every) if drawn else None)


def _range(
    value: Mapping[str, Any], source: str, key: str, names: Sequence[str]
) -> tuple[RangeKeys, float, float]:
    section = f"axes.{key}"
    require(len(names) == 1, source, section, dict(value), "a list of lists, one for each step")
    keys = validated(value, RangeKeys, source, section, others=("from", "to"))
    for end in ("from", "to"):
        if end not in value:
            raise InputError(f"{source}: key {section}.{end} is missing, expected a number; {_FIX}")
    low, high = (
        float(validated_value(value[end], float, source, f"{section}.{end}"))
        for end in ("from", "to")
    )
    require(keys.scale in SCALES, source, f"{section}.scale", keys.scale, _one_of(SCALES))
    require(keys.draw in ("", *DRAWS), source, f"{section}.draw", keys.draw, _one_of(DRAWS))
    require(low < high, source, f"{section}.to", high, f"more than from = {low:g}")
    positive = keys.scale == "linear" or low > 0.0
    require(positive, source, f"{section}.from", low, "more than 0 for a log scale")
    return keys, low, high


def _ranged(
    key: str, keys: RangeKeys, low: float, high: float, whole: set[str], source: str
) -> Axis:
    if not keys.steps:
        raise InputError(
            f"{source}: key axes.{key}.steps is missing, expected how many values the range has; "
            f'add it, or draw = "latin" and points for the whole sweep'
        )
    shares = np.arange(keys.steps) / (keys.steps - 1)
    values = _rounded(key, _placed(shares, keys, low, high), whole)
    return Axis((key,), tuple((value,) for value in dict.fromkeys(values)))


def _drawn(
    key: str, keys: RangeKeys, low: float, high: float, points: int, source: str
) -> list[float]:
    """Values of one drawn axis, by its name alone.

    A random axis keeps its first values when more points are asked for. A Latin hypercube has one
    value in each of ``points`` equal parts (McKay, Beckman and Conover, Technometrics 21, 1979),
    so another number of points moves all of them.
    """
    require(not keys.steps, source, f"axes.{key}.steps", keys.steps, "none for an axis with draw")
    if not points:
        raise InputError(
            f"{source}: key axes.{key} is drawn and points is missing, expected how many are "
            f"drawn; add points = 20 above the tables"
        )
    rng = np.random.default_rng(int.from_bytes(hashlib.sha256(key.encode()).digest()[:8], "big"))
    if keys.draw == "random":
        shares = rng.random(points)
    else:
        shares = (rng.permutation(points) + rng.random(points)) / points
    return _placed(shares, keys, low, high)


def _placed(shares: Any, keys: RangeKeys, low: float, high: float) -> list[float]:
    """Values at shares of a range."""
    if keys.scale == "log":
        return [float(low * (high / low) ** share) for share in shares]
    return [float(low + (high - low) * share) for share in shares]


def _rounded(key: str, values: Sequence[float], whole: set[str]) -> tuple[Setting, ...]:
    """To 12 digits, so that 30.000000000000004 is 30; whole numbers where the key wants them."""
    if key in whole:
        return tuple(round(value) for value in values)
    return tuple(float(f"{value:.12g}") for value in values)


def _listed(key: str, names: Sequence[str], value: Any, source: str) -> Axis:
    section = f"axes.{key}"
    require(isinstance(value, list) and bool(value), source, section, value, f"values; {_FIX}")
    rows = [(one,) if len(names) == 1 else one for one in value]
    for row in rows:
        several = isinstance(row, list | tuple) and len(row) == len(names)
        expected = f"a list of {len(names)} values for each step, one for each key"
        require(several, source, section, row, expected)
        for one in row:
            require(_is_setting(one), source, section, one, "finite numbers or texts")
    kinds = {tuple(isinstance(one, str) for one in row) for row in rows}
    require(len(kinds) == 1, source, section, value, "numbers alone or texts alone")
    require(len(set(map(tuple, rows))) == len(rows), source, section, value, "each value once")
    return Axis(tuple(names), tuple(tuple(row) for row in rows))


def _is_setting(value: Any) -> bool:
    return isinstance(value, int | str) or (isinstance(value, float) and math.isfinite(value))


def _one_of(words: Sequence[str]) -> str:
    return f"one of {', '.join(words)}"
