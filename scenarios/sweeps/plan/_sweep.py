"""A sweep file, read and checked."""

from __future__ import annotations

import hashlib
import itertools
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from msgspec import Meta

from servosight.models.core import (
    InputError,
    did_you_mean,
    plain,
    read_settings,
    read_text,
    require,
    validated,
    within,
)
from servosight.scenarios.scenario import Scenario
from servosight.scenarios.sweeps.plan._axes import Design, read_axes
from servosight.scenarios.sweeps.plan._lines import with_lines
from servosight.scenarios.sweeps.plan._scenario import scenario_of, whole_keys
from servosight.scenarios.sweeps.plan._user import digest_of
from servosight.scenarios.sweeps.plan._versions import code_digest

THROUGH = ("angles", "video")
MODELS = ("hidden", "linear")
VERBS = ("identify", "diagnose")

READY = {path.stem: path for path in sorted((Path(__file__).parents[1] / "ready").glob("*.toml"))}
"""The sweep files that come with the program, by name."""

_SEEDS = Meta(
    description="how many seeds, or a list of whole numbers from 0",
    extra={"fix": "write seeds = 20"},
)
_SCENARIO = Meta(
    description="the path of a scenario, or a table of its keys",
    extra={"fix": "write [scenario] and its keys below"},
)
_AXES = Meta(
    description="a table of axes",
    extra={"fix": "write [axes] and below it noise_deg = [0.01, 0.1]"},
)
_DO = Meta(description=f"a list of {', '.join(VERBS)} or module:function")


@dataclass(frozen=True)
class CellLimits:
    """What one cell may take; where it takes more, it is given up, and its row says so."""

    seconds: Annotated[float, within(0.1, 1e6, "seconds")] = 600.0
    memory_mb: Annotated[float, within(200.0, 1e6, "MB of a worker's resident memory")] = 4000.0


@dataclass(frozen=True)
class SweepKeys:
    """The keys of a sweep file."""

    axes: Annotated[dict[str, Any], _AXES]
    scenario: Annotated[str | dict[str, Any], _SCENARIO] = field(default_factory=dict)
    seeds: Annotated[int | list[int], _SEEDS] = 1
    through: str = "angles"
    do: Annotated[list[str], _DO] = field(default_factory=lambda: list(VERBS))
    model: str = "hidden"
    points: Annotated[int, Meta(ge=0, le=1_000_000, description="how many points are drawn")] = 0
    about: str = ""
    limits: CellLimits = field(default_factory=CellLimits)


@dataclass(frozen=True)
class Sweep:
    """A sweep: what :func:`read_sweep` reads.

    ``base`` is the scenario's table and ``design`` what changes in it. ``model`` says which effects
    ``identify`` fits: those that the cell hides, or none.
    """

    name: str
    base: Mapping[str, Any]
    design: Design
    seeds: tuple[int, ...]
    through: str
    do: tuple[str, ...]
    model: str
    about: str
    limits: CellLimits
    source: str

    @property
    def video(self) -> bool:
        """True where each cell films its servo and tracks the video."""
        return self.through == "video"

    @property
    def size(self) -> int:
        """How many cells there are."""
        return self.design.size * len(self.seeds)

    @property
    def recipe(self) -> dict[str, Any]:
        """All that makes a row beside its axes and its seed."""
        found: dict[str, Any] = plain(
            {
                "scenario": self.base,
                "axes": sorted(self.design.names),
                "through": self.through,
                "do": list(self.do),
                "model": self.model,
                "code": code_digest(video=self.video, diagnosing="diagnose" in self.do),
                "functions": [digest_of(one, self.source) for one in self.do if one not in VERBS],
            }
        )
        return found

    @cached_property
    def made(self) -> str:
        """A hash over :attr:`recipe`: rows in which it differs are not mixed."""
        text = json.dumps(self.recipe, sort_keys=True, ensure_ascii=False)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def read_sweep(given: Path | str | Mapping[str, Any]) -> Sweep:
    """Read a sweep: a file, the name of a ready one (:data:`READY`), or a table of its keys.

    Raises InputError, which names the file, the line, the key, what was expected and how to
    correct it. Every axis value is tried in a scenario before any cell runs.

    >>> read_sweep("noise_by_frame_rate").design.names
    ('noise_deg', 'camera.rate_hz')
    """
    if isinstance(given, Mapping):
        return _sweep(given, "sweep", "the sweep", Path())
    path = Path(given)
    if not path.exists():
        if str(given) not in READY:
            near = did_you_mean(str(given), READY)
            raise InputError(
                f"{given}: no such file, expected a sweep in TOML or one of {', '.join(READY)}"
                f"{near}; check the name"
            )
        path = READY[str(given)]
    expected = "a sweep in TOML, with lines such as seeds = 20"
    table = read_settings(path, expected)
    with with_lines(str(given), read_text(path, expected)):
        return _sweep(table, path.stem, str(given), path.parent)


def _sweep(table: Mapping[str, Any], name: str, source: str, folder: Path) -> Sweep:
    keys = validated(table, SweepKeys, source)
    require(keys.through in THROUGH, source, "through", keys.through, _one_of(THROUGH))
    require(keys.model in MODELS, source, "model", keys.model, _one_of(MODELS))
    require(bool(keys.do), source, "do", keys.do, "at least one thing that a cell does")
    require(bool(keys.axes), source, "axes", keys.axes, "at least one axis")
    sweep = Sweep(
        name=name,
        base=_base(keys.scenario, source, folder),
        design=read_axes(keys.axes, keys.points, set(whole_keys()), source),
        seeds=_seeds(keys.seeds, source),
        through=keys.through,
        do=tuple(dict.fromkeys(keys.do)),
        model=keys.model,
        about=keys.about,
        limits=keys.limits,
        source=source,
    )
    sweep.recipe  # noqa: B018, a function that cannot be imported is reported before any cell
    _try_values(sweep)
    return sweep


def _base(given: str | Mapping[str, Any], source: str, folder: Path) -> dict[str, Any]:
    """The scenario's table, without what the sweep sets."""
    if isinstance(given, str):
        path = folder / given
        require(path.is_file(), source, "scenario", given, "a file with a scenario in TOML")
        given = read_settings(path, f"the scenario in TOML that {source} names in its key scenario")
        Scenario.of(given, str(path))
    return {key: value for key, value in given.items() if key not in ("seed", "video")}


def _seeds(given: int | list[int], source: str) -> tuple[int, ...]:
    seeds = tuple(range(given)) if isinstance(given, int) else tuple(given)
    right = bool(seeds) and min(seeds) >= 0 and len(set(seeds)) == len(seeds)
    require(right, source, "seeds", given, "how many (1 or more), or a list of different ones")
    return seeds


def _try_values(sweep: Sweep) -> None:
    """Make the scenario of every axis value, the others at their first ones."""
    axes = [*sweep.design.grid, *([sweep.design.points] if sweep.design.points else [])]
    first: dict[str, Any] = {}
    for axis in axes:
        first |= next(axis.steps())
    tried = ({**first, **step} for axis in axes for step in itertools.islice(axis.steps(), 1000))
    for settings in itertools.chain([first], tried):
        scenario_of(sweep.base, settings, 0, 0, video=sweep.video, source=sweep.source)


def _one_of(words: tuple[str, ...]) -> str:
    return f"one of {', '.join(words)}"
