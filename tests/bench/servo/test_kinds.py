"""Every place that names the kinds of servo has those that have a driver.

The wizard and the rehearsal name them on their own, so that they ask before anything large is
imported.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import get_args, get_type_hints

import pytest
from support.wires import KEYS, STAND_INS, STEP_DEG

from servosight._verbs import bench as verbs
from servosight.app.commands.bench import _options as options
from servosight.app.commands.bench import _wizard as wizard
from servosight.bench.servo import servo_kinds
from servosight.models.core import Recording
from servosight.scenarios.rehearsal import Rehearsal
from servosight.scenarios.rehearsal import _bench as virtual


def _literal(function: object, **types: type) -> tuple[str, ...]:
    return get_args(get_type_hints(function, localns=types)["kind"])


PLACES = {
    "bench --kind": options.KINDS,
    "questions of the wizard": wizard._KINDS,
    "keys the wizard asks for": wizard._KEYS,
    "type of a rehearsal": get_args(virtual.Kind),
    "field of a rehearsal": _literal(Rehearsal),
    "keys of a rehearsal": virtual._KEYS,
    "ss.bench.rehearse": _literal(verbs.rehearse, Recording=Recording),
    "stand-ins of the tests": STAND_INS,
    "keys of the tests": KEYS,
    "steps of the tests": STEP_DEG,
}


@pytest.mark.parametrize("kinds", PLACES.values(), ids=PLACES)
def test_kinds_are_those_of_the_drivers(kinds: Iterable[str]) -> None:
    assert sorted(kinds) == sorted(servo_kinds())


def test_every_kind_with_a_light_is_one_of_the_wizards() -> None:
    assert set(wizard._LIGHTS) <= set(wizard._KINDS)


@pytest.mark.parametrize("kind", servo_kinds())
def test_every_kind_has_its_stand_in_in_a_rehearsal(kind: virtual.Kind) -> None:
    plant = virtual.LiveTwin(Rehearsal().servo.bench(), {})
    assert isinstance(virtual._stand_in(kind, plant), type(STAND_INS[kind]()))
