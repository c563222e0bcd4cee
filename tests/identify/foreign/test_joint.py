"""Parameters of an FMU fitted together with those of effects around it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import servosight as ss
from servosight.app.main import main
from servosight.export.core import ExportRequest
from servosight.export.csource import missing
from servosight.export.fmu import FMU2
from servosight.identify.foreign import identify_fmu
from servosight.models.core import Actuator, Array, Estimate, Recording
from servosight.models.effects import catalogue
from servosight.models.io import save_recording
from servosight.models.plant import Plant, Stimulus

pytestmark = pytest.mark.skipif(missing() is not None, reason="needs a C compiler")

TRUE = {"k": 0.9, "T": 0.03, "xi": 0.7, "dead_time.delay": 0.02, "backlash.gap": 1.2}
OTHER = {"k": 0.8, "T": 0.045, "xi": 1.0, "bias": 0.0}
TIMES = np.arange(0.0, 4.0, 0.02)
NOISE_DEG = 0.03


def seen(bias: float, command: Array, seed: int) -> Recording:
    """What the plant kernel makes of the true values, with noise."""
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    for name, value in {**TRUE, "bias": bias, "initial_angle": bias}.items():
        row[plant.index(name)] = value
    made = Recording("made", TIMES, command, TIMES, np.zeros(TIMES.size))
    angle = plant.simulate(row, Stimulus.of(made))
    noise = np.random.default_rng(seed).normal(0.0, NOISE_DEG, TIMES.size)
    return Recording(f"made {seed}", TIMES, command, TIMES, angle + noise)


RECORDINGS = [
    seen(0.3, 12.0 * np.sign(np.sin(4.0 * TIMES)) + 6.0 * np.sin(11.0 * TIMES), 4),
    seen(-0.6, 15.0 * np.sin(2.0 * TIMES + 1.5 * TIMES**2), 5),
]


def written(values: dict[str, float], place: Path) -> Path:
    effects = tuple(dict.fromkeys(name.split(".")[0] for name in values if "." in name))
    card = Actuator({name: Estimate(v, None, "") for name, v in values.items()}, effects)
    FMU2.write(ExportRequest(actuator=card, catalogue=catalogue(), name="servo"), place)
    return place


@pytest.fixture(scope="module")
def linear(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The linear core with values that are none of the servo's."""
    return written(OTHER, tmp_path_factory.mktemp("linear") / "linear.fmu")


def test_core_and_effects_come_back_within_their_uncertainty(linear: Path) -> None:
    """From k, T and xi that are 11, 50 and 43 % off; alone the core leaves ten times the noise."""
    alone = identify_fmu(linear, RECORDINGS, trust=True)
    assert alone.rmse_deg > 10.0 * NOISE_DEG
    fit = identify_fmu(linear, RECORDINGS, effects=["dead_time", "backlash"], trust=True)
    assert fit.rmse_deg == pytest.approx(NOISE_DEG, rel=0.1)
    for name, value in TRUE.items():
        one = fit.parameters[name]
        assert isinstance(one, Estimate)
        assert one.sigma is not None
        assert abs(one.value - value) < 4.0 * one.sigma, name
    assert fit.covariance.names == tuple(TRUE)
    biases = fit.parameters["bias"]
    assert isinstance(biases, tuple)
    assert [one.value for one in biases] == pytest.approx([0.3, -0.6], abs=0.05)


def test_what_is_named_is_fitted_and_the_effects_with_it(
    linear: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_recording(RECORDINGS[0], tmp_path / "rec")
    words = ["identify", str(tmp_path / "rec"), "--model", str(linear), "--trust", "--json", "-"]
    words += ["--effects", "backlash"]
    held = ["--fix", "T=0.03", "--parameters", "k"]
    assert main([*words, *held]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["covariance"]["names"] == ["k", "backlash.gap"]
    assert found["parameters"]["T"] == {"value": 0.03, "sigma": 0.0, "unit": "s"}
    fit = ss.identify(
        RECORDINGS[0], ["backlash"], model=linear, fix={"backlash.gap": 1.2}, trust=True
    )
    assert fit.parameters["backlash.gap"] == Estimate(1.2, 0.0, "deg")


def test_effects_that_cannot_be_around_it_are_refused(
    linear: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_recording(RECORDINGS[0], tmp_path / "rec")
    own = written({**OTHER, "backlash.gap": 0.5}, tmp_path / "own.fmu")
    for fmu, effects, said in (
        (linear, "coulomb_friction", "acts inside the position loop"),
        (linear, "backlsh", "did you mean backlash?"),
        (own, "backlash", "has a parameter backlash.gap itself, expected effects that it lacks"),
    ):
        words = ["identify", str(tmp_path / "rec"), "--model", str(fmu), "--effects", effects]
        assert main([*words, "--trust"]) == 2
        error = capsys.readouterr().err
        assert said in error
        assert error.count("\n") == 1
