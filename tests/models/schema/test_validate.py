"""The reader of settings: typed values, or one sentence that names file, key, range and remedy."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

import pytest

from servosight.models.core import InputError, check_fields, share, validated, within


@dataclass(frozen=True)
class Lamp:
    brightness: Annotated[float, share()] = 0.5
    name: str | None = None


@dataclass(frozen=True)
class Room:
    width_m: Annotated[float, within(1.0, 20.0, "metres", "write 250 cm as 2.5")]
    size_px: tuple[int, int] = (1, 1)
    lamp: Lamp | None = None
    lamps: Mapping[str, Lamp] = field(default_factory=dict)


def test_what_is_right_is_read_with_its_type() -> None:
    table = {"width_m": 3, "size_px": [4, 5], "lamps": {"a": {"brightness": 1}}, "lamp": {}}
    room = validated(table, Room, "room.toml")
    assert room == Room(3.0, (4, 5), Lamp(), {"a": Lamp(1.0)})
    assert isinstance(room.width_m, float)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({}, "key width_m is missing, expected 1 to 20 metres; write 250 cm as 2.5"),
        ({"width_m": 0.5}, "key width_m is 0.5, expected 1 to 20 metres; write 250 cm as 2.5"),
        ({"width_m": math.nan}, "key width_m is nan, expected a finite number"),
        ({"width_m": True}, "key width_m is True, expected 1 to 20 metres"),
        ({"width_m": 2, "lamp": 3}, "key lamp is 3, expected a table; write [lamp]"),
        ({"width_m": 2, "lamp": {"name": 3}}, "key lamp.name is 3, expected a text"),
        (
            {"width_m": 2, "lamps": {"a": {"brightness": 2}}},
            "key lamps.a.brightness is 2.0, expected a share of 0 to 1; write 5 % as 0.05",
        ),
        ({"width_m": 2, "size_px": [1]}, "key size_px is [1], expected tuple[int, int]"),
        (
            {"width_m": 2, "lamp": {"brigthness": 1}},
            "unknown key lamp.brigthness, expected one of brightness, name "
            "(did you mean lamp.brightness?); rename or remove it",
        ),
        (3, "room.toml: is 3, expected a table; write one"),
    ],
)
def test_what_is_wrong_is_one_sentence(table: Any, said: str) -> None:
    with pytest.raises(InputError) as caught:
        validated(table, Room, "room.toml")
    assert said in str(caught.value)
    assert str(caught.value).startswith("room.toml: ")


def test_notes_of_the_users_own_may_stand_beside_keys() -> None:
    assert validated({"width_m": 2, "colour": "red"}, Room, "room.toml", notes=True) == Room(2.0)
    with pytest.raises(InputError, match="expected width_m; rename it or, if it is a note"):
        validated({"width_m": 2, "with_m": 3}, Room, "room.toml", notes=True)


def test_a_value_that_was_made_is_held_to_the_same_ranges() -> None:
    check_fields(Room(2.0, lamp=Lamp()), "--set")
    with pytest.raises(InputError, match=r"--set: key lamp.brightness is 3.0, expected a share"):
        check_fields(Room(2.0, lamp=Lamp(3.0)), "--set")
