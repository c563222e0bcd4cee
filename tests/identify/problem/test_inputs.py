"""A known disturbance as an input of a fit: against the twin, and where no recording has one.

Truth: the twin, where MuJoCo applies the disturbance as a torque on the motor's hinge, by physics
that shares no line with the plant. The noise is 0.03 deg.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from servosight.app.main import main
from servosight.diagnose import diagnose
from servosight.identify.fit import identify
from servosight.identify.problem import offered
from servosight.models.core import InputError, Recording, Side
from servosight.models.effects import catalogue
from servosight.models.io import load_recording, save_recording
from servosight.models.plant import Plant, Stimulus
from servosight.scenarios.produce import simulated
from servosight.scenarios.scenario import Scenario
from servosight.scenarios.settings import CommandSettings

GAIN = 0.15
NOISE_DEG = 0.03


def pushed(gain: float = GAIN, **beside: dict[str, float]) -> Recording:
    """12 s of steps, chirp and triangles with pulses of 20 N; ``beside``: further effects."""
    return simulated(
        Scenario(
            seed=3,
            duration_s=12.0,
            noise_deg=NOISE_DEG,
            motion=CommandSettings(amplitude_deg=15.0),
            effects={"known_disturbance": {"gain": gain}, **beside},
        )
    )


@pytest.mark.parametrize("beside", [{}, {"coulomb_friction": {"level": 1.2}}])
def test_its_gain_is_found_on_the_twin(beside: dict[str, dict[str, float]]) -> None:
    """Bound: 3 sigma and 1 % of the truth, which MuJoCo's friction leaves."""
    recording = pushed(**beside)
    fit = identify(recording, ["known_disturbance", *beside], method="gradient")
    found = fit.parameters["known_disturbance.gain"]
    assert found.sigma is not None
    error = abs(found.value - GAIN)
    print(
        f"truth {GAIN}, found {found.value:.5f} +- {found.sigma:.1e}, rmse {fit.rmse_deg:.4f} deg"
    )
    assert error <= 3.0 * found.sigma + 0.01 * GAIN
    assert found.sigma < 0.01 * GAIN
    assert fit.rmse_deg < 1.1 * NOISE_DEG
    assert not any("known disturbance" in note for note in fit.warnings)


def test_a_fit_without_it_says_so_and_errs_by_it() -> None:
    fit = identify(pushed(), method="gradient")
    (note,) = (one for one in fit.warnings if "known disturbance" in one)
    assert "(up to 20.0 N) is recorded and not used" in note
    assert note.endswith("the effect known_disturbance takes it as one")
    assert fit.rmse_deg > 5.0 * NOISE_DEG


def test_it_is_diagnosed() -> None:
    """Named alone, and explained; a force that moves nothing is not named and said to be unused."""
    found = diagnose([pushed()], auto=True)
    assert (found.verdict.value, found.effects) == ("explained", ("known_disturbance",))
    assert not any("not used as an input" in note for note in found.warnings)
    idle = diagnose([pushed(gain=0.0)], auto=True)
    assert (idle.verdict.value, idle.effects) == ("no_effect_missing", ())
    assert any("not used as an input" in note for note in idle.warnings)


def test_it_carries_over_to_another_gain_of_the_loop() -> None:
    """A torque in degrees falls as one over the gain: two recordings, one parameter."""
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    row[:3] = 1.0, 0.03, 0.6
    first = pushed()
    made = []
    for number, gain in enumerate((1.0, 4.0)):
        own = row.copy()
        own[1:3] /= np.sqrt(gain)
        own[plant.index("known_disturbance.gain")] = GAIN / gain
        angle = plant.simulate(own, Stimulus.of(first))
        noise = np.random.default_rng(number).normal(0.0, NOISE_DEG, angle.size)
        made.append(replace(first, angle_deg=angle + noise, relative_gain=gain))
    fit = identify(made, ["known_disturbance"], method="gradient")
    found = fit.parameters["known_disturbance.gain"]
    assert found.sigma is not None
    assert abs(found.value - GAIN) <= 3.0 * found.sigma


def test_it_is_offered_where_a_recording_has_one_alone() -> None:
    """On the same plant: no other kernel is compiled."""
    known, recording = catalogue(), pushed()
    assert offered(known, [recording]) is known
    bare = offered(known, [replace(recording, signals=None)])
    assert set(known) - set(bare) == {"known_disturbance"}
    assert Plant.of(bare) is Plant.of(known)
    with pytest.raises(InputError, match=r"known_disturbance acts by a known disturbance.*--map"):
        identify(replace(recording, signals=None), ["known_disturbance"])


@pytest.mark.parametrize(
    ("sides", "gone"),
    [
        (("surface",), set()),
        (("horn", "surface"), set()),
        (("horn",), {"backlash", "linkage_geometry"}),
        (("sensor", "sensor"), {"backlash", "linkage_geometry", "sensor_nonlinearity"}),
        (("sensor", "horn"), {"backlash", "linkage_geometry"}),
    ],
)
def test_what_lies_behind_the_measured_angle_is_not_offered(
    sides: tuple[Side, ...], gone: set[str]
) -> None:
    known = catalogue()
    recordings = [replace(pushed(), side=side) for side in sides]
    assert set(known) - set(offered(known, recordings)) == gone
    assert set(known) - set(offered(known, recordings, ["backlash"])) == gone - {"backlash"}


def test_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Saved, fitted, and predicted from the model card: the pulses come from signals.csv."""
    recording, rec, card = pushed(), tmp_path / "rec", tmp_path / "model.toml"
    save_recording(recording, rec)
    words = ["identify", str(rec), "--effects", "known_disturbance", "--method", "gradient"]
    assert main([*words, "-o", str(card), "--json", "-"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["parameters"]["known_disturbance.gain"]["unit"] == "deg/unit"
    assert main(["predict", str(card), str(rec), "-o", str(tmp_path / "angle.csv")]) == 0
    predicted = np.loadtxt(tmp_path / "angle.csv", delimiter=",", skiprows=1)[:, 1]
    assert np.sqrt(np.mean((predicted - load_recording(rec).angle_deg) ** 2)) < 2.0 * NOISE_DEG
