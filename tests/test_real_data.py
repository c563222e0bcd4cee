"""Real servos, where SERVOSIGHT_DATA names the logs: a fast part of `benchmarks/real.py`."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from servosight.diagnose import diagnose
from servosight.identify.fit import fit_effects, identify
from servosight.identify.problem import Problem
from servosight.models.core import Recording
from servosight.models.effects import catalogue
from servosight.models.io.importers import Request
from servosight.models.io.importers.formats._bam import read_bam
from servosight.models.io.importers.formats._mat import EMPS_SCALE, read_mat

DATA = os.environ.get("SERVOSIGHT_DATA")
pytestmark = pytest.mark.skipif(
    not DATA, reason="SERVOSIGHT_DATA names no folder with the logs of real servos"
)
GAINS = (100, 200, 400, 800)


def data(*parts: str) -> Path:
    """A file of the logs."""
    return Path(str(DATA)).joinpath(*parts)


def emps_thinned(every: int, rows: int | None = None) -> tuple[Recording, dict[str, float]]:
    """One in so many of EMPS's 24,841 samples, and what its file says of the loop."""
    whole = read_mat(data("emps", "DATA_EMPS.mat"), Request())
    thinned = Recording(
        whole.name,
        whole.command_time_s[:rows],
        whole.command_deg[:rows],
        whole.time_s[:rows:every],
        whole.angle_deg[:rows:every],
    )
    return thinned, whole.details["source"]


def test_the_ladder_names_coulomb_friction_on_emps() -> None:
    """With a tolerance of two micrometres: by default the linear model is good enough.

    The first half of the run tells as much, in half the time.
    """
    recording, _ = emps_thinned(20, 12_420)
    found = diagnose([recording], catalogue=catalogue(), auto=True, tolerance=2e-4)
    assert found.effects == ("coulomb_friction",)
    assert found.verdict == "explained"


def test_emps_friction_and_offset_come_out_in_newtons() -> None:
    """Published: Fc 20.39 N, held within 5 %, and an offset of -3.16 N, within a newton.

    A position error of a metre is a force of gtau kv kp.
    """
    recording, source = emps_thinned(10)
    newtons_per_deg = source["gtau"] * source["kv"] * source["kp"] / EMPS_SCALE
    found = identify(
        [recording], ["coulomb_friction"], catalogue=catalogue(), method="gradient"
    ).actuator
    assert newtons_per_deg * found.value("coulomb_friction.level") == pytest.approx(20.39, rel=0.05)
    assert -newtons_per_deg * found.value("bias") == pytest.approx(-3.16, abs=1.0)


def test_one_set_of_parameters_serves_four_gains() -> None:
    """Gravity and load-dependent friction take the linear model's error to a fifth.

    Seen: 162.6 to 28.7 mrad, mean absolute error over the four gains; BAM m3 26.7.
    """
    fitted = [read_bam(data("xl330", f"sin_sin_kp{gain}.json"), Request()) for gain in GAINS]
    assert [recording.relative_gain for recording in fitted] == [0.25, 0.5, 1.0, 2.0]
    fit, errors = None, []
    for effects in ((), ("gravity_load",), ("load_dependent_friction", "gravity_load")):
        fit = fit_effects(Problem.of(fitted, catalogue(), effects), fit)
        predicted = fit.problem.predict(fit.outcome.point)
        errors.append(
            np.mean(
                [
                    1e3 * np.radians(np.abs(recording.angle_deg - angles[0])).mean()
                    for recording, angles in zip(fitted, predicted, strict=True)
                ]
            )
        )
    assert errors[-1] < 30.0
    assert errors[-1] < 0.2 * errors[0]
