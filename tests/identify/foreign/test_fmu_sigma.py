"""The sigmas of an FMU's parameters hold what another run of the same servo gives."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.uncertainties import assessed

from servosight.export.core import ExportRequest
from servosight.export.csource import missing
from servosight.export.fmu import FMU2
from servosight.identify.foreign import identify_fmu
from servosight.models.core import Actuator, Estimate, Recording
from servosight.models.effects import catalogue
from servosight.models.excitation import multisine
from servosight.models.plant import Plant, Stimulus

pytestmark = pytest.mark.skipif(missing() is not None, reason="needs a C compiler")

CORE = {"k": 1.0, "T": 0.022, "xi": 0.6}
RUNS = 20
COMMAND_TIMES = np.arange(1200) / 100.0
TIMES = 0.004 + np.arange(590) / 50.0
NOISE_DEG = 0.03


@pytest.fixture(scope="module")
def linear(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The linear core as an FMU, 10 % off."""
    begun = {**{name: 1.1 * value for name, value in CORE.items()}, "bias": 0.0}
    card = Actuator({name: Estimate(value, None, "") for name, value in begun.items()}, ())
    place = tmp_path_factory.mktemp("linear") / "linear.fmu"
    FMU2.write(ExportRequest(actuator=card, catalogue=catalogue(), name="servo"), place)
    return place


def run(seed: int, level: float) -> Recording:
    """A servo with friction of ``level`` [deg] that follows a multisine, one of many alike."""
    command = multisine(COMMAND_TIMES, 20.0, 0.2, 4.0, seed)
    made = Recording(f"run {seed}", COMMAND_TIMES, command, TIMES, np.zeros(TIMES.size))
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    for name, value in {**CORE, "coulomb_friction.level": level}.items():
        row[plant.index(name)] = value
    angle = plant.simulate(row, Stimulus.of(made))
    noise = np.random.default_rng([seed, 3]).normal(0.0, NOISE_DEG, TIMES.size)
    return replace(made, angle_deg=angle + noise)


@pytest.mark.parametrize("level", [0.03, 0.5], ids=["below the noise", "far above"])
def test_the_fits_scatter_as_much_as_their_sigmas_say(linear: Path, level: float) -> None:
    """k, T and xi of 20 runs about their own medians: of 60 values 54 to 58 are to be within two
    sigma, 90 to 97 %, and three fewer by chance. Those of k are what a fit of the equation has, but
    for the solver's errors and the descents' ends."""
    names = tuple(CORE)
    values, sigmas = np.empty((RUNS, 3)), np.empty((RUNS, 3))
    recordings = [run(seed, level) for seed in range(RUNS)]
    for i, recording in enumerate(recordings):
        fit = identify_fmu(linear, [recording], names, trust=True)
        for j, name in enumerate(names):
            one = fit.parameters[name]
            assert isinstance(one, Estimate)
            assert one.sigma
            values[i, j], sigmas[i, j] = one.value, one.sigma
    within = int(np.sum(np.abs(values - np.median(values, axis=0)) < 2.0 * sigmas))
    print(f"{within} of 60 within two sigma")
    assert within >= 51
    of_equation = [float(assessed(recording).sigma[0]) for recording in recordings]
    assert sigmas[:, 0] == pytest.approx(of_equation, rel=0.05)
