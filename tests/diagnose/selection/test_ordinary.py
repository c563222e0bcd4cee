"""Which effects of the catalogue the search treats unlike others, by what they declare."""

from __future__ import annotations

from typing import Any

import pytest

from servosight.diagnose.selection import SelectionPolicy
from servosight.diagnose.selection._ordinary import at_several_gains, usual
from servosight.models.core import InputError
from servosight.models.effects import Effect, Usual, catalogue

EFFECTS = catalogue()


def test_each_ordinary_effect_is_one_of_the_catalogue_after_what_it_needs() -> None:
    """Friction by load shows only once the weight of an arm does."""
    ordinary = SelectionPolicy().ordinary
    assert len(set(ordinary)) == len(ordinary)
    assert set(ordinary) <= set(EFFECTS)
    weight = ordinary.index(*usual(EFFECTS, Usual.WEIGHT))
    by_load = [name for name in ordinary if name.startswith(("load_", "directional_"))]
    assert len(by_load) == 3
    assert all(ordinary.index(name) > weight for name in by_load)


def test_what_every_servo_has() -> None:
    assert usual(EFFECTS, Usual.WEIGHT) == ("gravity_load",)
    assert usual(EFFECTS, Usual.FRICTION) == ("coulomb_friction", "load_dependent_friction")


def test_what_recordings_at_several_gains_try_in_the_place_of_another() -> None:
    ordinary = SelectionPolicy().ordinary
    found = at_several_gains(ordinary, EFFECTS)
    changed = [(old, new) for old, new in zip(ordinary, found, strict=True) if old != new]
    assert changed == [
        ("torque_saturation", "current_limit"),
        ("current_limit", "torque_saturation"),
    ]


@pytest.mark.parametrize(
    ("field", "wrong", "expected"),
    [
        ("usual", "weight", "a member of Usual or None"),
        ("for_several_gains", 3, "an effect id or None"),
        ("together_with", "backlash", "a tuple of effect ids"),
    ],
)
def test_a_declaration_of_another_kind_is_refused(field: str, wrong: Any, expected: str) -> None:
    given = {name: getattr(EFFECTS["backlash"], name) for name in Effect.__dataclass_fields__}
    with pytest.raises(InputError, match=f"backlash'?: {field} is .*expected {expected}"):
        Effect(**{**given, field: wrong})
