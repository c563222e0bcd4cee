"""docs/json.md lists every key that a result writes."""

from __future__ import annotations

import dataclasses
import re
import typing
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import UnionType
from typing import Any

import numpy as np
import pytest

import servosight as ss
from servosight.identify.fit import Fit
from servosight.identify.foreign import FmuFit
from servosight.models.core import Frozen, InputError, Result
from servosight.models.effects import EffectInfo, EffectTable

PAGE = Path(__file__).resolve().parents[1] / "docs" / "json.md"
BY_NAME = {"parameters", "start", "fixed", "relative_sigma", "change"}
"""What is keyed by the names of parameters or effects, not by keys of the format."""
RESULTS: tuple[type[Result], ...] = (
    *(ss.Fit, ss.Comparison, ss.Diagnosis, ss.Track, ss.ServoChange, ss.ExportResult, FmuFit),
    EffectInfo,
)


def documented() -> set[str]:
    """All that stands as code on the page, word by word."""
    text = PAGE.read_text(encoding="utf-8")
    codes = re.findall(r"`([^`]+)`", text)
    return {word for code in codes for word in re.findall(r"\w+", code)}


def fields_of(kind: Any) -> Iterator[str]:
    """Names of the fields of a dataclass and of all dataclasses in it: keys that may be written."""
    if dataclasses.is_dataclass(kind):
        hints = typing.get_type_hints(kind, localns=vars(typing) | {"Mapping": Mapping})
        for field in dataclasses.fields(kind):
            yield field.name
            yield from fields_of(hints[field.name])
    elif typing.get_origin(kind) is not None or isinstance(kind, UnionType):
        for inner in typing.get_args(kind):
            yield from fields_of(inner)


def written(value: Any, key: str = "") -> Iterator[str]:
    """All keys of a JSON, but names of parameters."""
    if isinstance(value, dict):
        for name, inner in value.items():
            if key not in BY_NAME:
                yield name
            yield from written(inner, "" if key in BY_NAME else name)
    elif isinstance(value, list):
        for inner in value:
            yield from written(inner, key)


@pytest.mark.parametrize("kind", RESULTS, ids=lambda kind: str(kind.TYPE))
def test_every_field_of_a_result_is_listed(kind: type[Result]) -> None:
    assert kind.TYPE in documented()
    assert not sorted(set(fields_of(kind)) - documented())


@pytest.mark.parametrize("kind", RESULTS, ids=lambda kind: str(kind.TYPE))
def test_every_kind_of_result_is_read_back(kind: type[Result], tmp_path: Path) -> None:
    """From a file that lacks its other keys, the next sentence is about one of those."""
    (tmp_path / "r.json").write_text(f'{{"schema": 1, "type": "{kind.TYPE}"}}')
    with pytest.raises(InputError, match="required field"):
        ss.load(tmp_path / "r.json")


def parts_of(kind: Any) -> Iterator[type]:
    """A dataclass, and all dataclasses in it."""
    if dataclasses.is_dataclass(kind):
        assert isinstance(kind, type)
        yield kind
        for hint in typing.get_type_hints(kind, localns={"Mapping": Mapping}).values():
            yield from parts_of(hint)
    for inner in typing.get_args(kind):
        yield from parts_of(inner)


@pytest.mark.parametrize("kind", RESULTS, ids=lambda kind: str(kind.TYPE))
def test_every_part_of_a_result_stays_as_it_was_made(kind: type[Result]) -> None:
    """Where it has arrays or mappings; the tracker works with its planes and shutters itself."""
    loose = [
        part.__name__
        for part in parts_of(kind)
        if not issubclass(part, Frozen)
        and any(map(changeable, typing.get_type_hints(part).values()))
    ]
    assert set(loose) <= {"MotionPlane", "Shutters"}


def changeable(hint: Any) -> bool:
    """True for an array or a mapping, or where it may be one."""
    if isinstance(hint, UnionType):
        return any(map(changeable, typing.get_args(hint)))
    return typing.get_origin(hint) in (np.ndarray, Mapping, dict)


def test_effects_are_saved_and_read_back(tmp_path: Path) -> None:
    one, table = ss.effects("flexible_shaft"), ss.effects()
    one.save(tmp_path / "one.json")
    table.save(tmp_path / "table.json")
    assert ss.load(tmp_path / "one.json") == one
    again = ss.load(tmp_path / "table.json")
    assert isinstance(again, EffectTable)
    assert again == table
    assert not sorted(set(written(table.to_dict())) - documented())
    (frequency, *_) = one.parameters
    assert (frequency.high, frequency.neutral) == (150.0, None)


def test_every_key_that_is_written_is_listed(tmp_path: Path) -> None:
    """Of a fit, a comparison and a change, as they come."""
    time_s = np.arange(0.0, 4.0, 0.01)
    command = np.where(time_s % 1.0 < 0.5, 10.0, -10.0)
    noise = np.random.default_rng(1).normal(0.0, 0.02, time_s.size)
    angle = np.convolve(command, np.full(10, 0.1))[: time_s.size] + noise
    recording = ss.Recording("steps", time_s, command, time_s, angle)
    fit = ss.identify(recording, method="gradient")
    results: list[Result] = [fit, ss.compare(fit, recording), ss.compare(fit, fit)]
    for result in results:
        keys = set(written(result.to_dict()))
        assert {"schema", "type"} <= keys
        assert not sorted(keys - documented()), type(result).__name__
    assert isinstance(Fit.from_dict(fit.to_dict()), Fit)
