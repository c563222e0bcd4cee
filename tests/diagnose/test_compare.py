"""One model beside recordings, and one effect more."""

from __future__ import annotations

import json
from typing import Any

import pytest
from support.vocabulary import WHATS

from servosight.diagnose import add, compare
from servosight.identify.fit import identify
from servosight.models.core import Actuator, Estimate, InputError
from servosight.models.effects import catalogue


def test_compare_judges_a_card_without_fitting_its_physics(twin: Any) -> None:
    """The true model lies at the floor, with a bias found anew; a gap 0.5 deg too wide does not.

    A gap wrong by 0.5 deg leaves about 0.25 deg wherever the surface moves.
    """
    recording, truth = twin("backlash")
    units = {"k": "-", "T": "s", "xi": "-", "bias": "deg", "backlash.gap": "deg"}
    values = {name: Estimate(value, None, units[name]) for name, value in truth.items()}
    values["bias"] = Estimate(99.0, None, "deg")
    right = compare(Actuator(values, ("backlash",)), [recording], catalogue=catalogue())
    assert right.explained
    assert right.rmse_deg <= 1.10 * right.floor_deg
    wide = Estimate(truth["backlash.gap"] + 0.5, None, "deg")
    wrong = compare(
        Actuator({**values, "backlash.gap": wide}, ("backlash",)),
        [recording],
        catalogue=catalogue(),
    )
    assert not wrong.explained
    assert 0.1 < wrong.rmse_deg < 0.3
    answer = json.loads(json.dumps(wrong.to_dict(), allow_nan=False))
    assert answer["recordings"][0]["samples"] == recording.time_s.size
    assert {one["what"] for one in answer["where"]} <= WHATS
    assert wrong.sentences


def test_add_brings_one_effect_and_fits_anew(twin: Any) -> None:
    recording, truth = twin("backlash")
    linear = identify([recording], [], catalogue=catalogue(), method="gradient")
    better = add(linear.actuator, "backlash", [recording], catalogue=catalogue())
    assert better.actuator.effects == ("backlash",)
    assert better.rmse_deg < 0.2 * linear.rmse_deg
    assert better.actuator.value("backlash.gap") == pytest.approx(truth["backlash.gap"], rel=0.05)
    with pytest.raises(InputError, match="already"):
        add(better.actuator, "backlash", [recording], catalogue=catalogue())
    with pytest.raises(InputError, match="expected one of"):
        add(better.actuator, "gremlins", [recording], catalogue=catalogue())
