"""What a command tells about a model: predictions held against fits and against known cases."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from servosight.identify.design import (
    Information,
    assess,
    better_command,
    optimal,
    predicted_experiment,
)
from servosight.identify.fit import identify
from servosight.models.core import Actuator, Estimate, InputError, Recording
from servosight.models.effects import catalogue
from servosight.models.excitation import SHAPES, CommandLimits, design

NOISE_DEG = 0.03
PAPER = {"k": 1.027, "T": 0.0078, "xi": 0.55, "bias": 0.0}


def actuator(**values: float) -> Actuator:
    named = {name.replace("__", "."): Estimate(x, None, "") for name, x in values.items()}
    return Actuator(named, tuple({name.split(".")[0] for name in named if "." in name}))


def told(model: Actuator, shape: str, limits: CommandLimits) -> Information:
    recording = predicted_experiment(design(shape, limits).excitation, 120.0)
    return assess(model, [recording], NOISE_DEG, catalogue=catalogue())


def test_the_papers_sine_does_not_pin_T_and_xi() -> None:
    """20 deg at 1 Hz shows (1 - omega^2 T^2) and 2 xi T omega. The gain takes up the first, so that
    raising T and lowering xi alike changes nothing: omega^2 T^2 is 0.0024.
    """
    found = told(actuator(**PAPER), "sine", CommandLimits(20.0, None, 20.0))
    assert not found.sufficient
    assert set(found.unsure) == {"T", "xi"}
    change = found.worst.change
    assert change["T"] * change["xi"] < 0.0
    assert abs(change["T"]) == pytest.approx(abs(change["xi"]), rel=0.05)
    assert abs(change["k"]) < 0.01 * abs(change["T"])
    assert found.worst.difference_deg < 0.2 * NOISE_DEG
    assert "T and xi are determined only together" in found.sentence
    assert "less than the noise" in found.sentence
    # However low the noise: the difference stays below what a model is right to.
    rows = predicted_experiment(design("sine", CommandLimits(20.0, None, 20.0)).excitation)
    quiet = assess(actuator(**PAPER), [rows], 1e-4, catalogue=catalogue())
    assert set(quiet.unsure) == {"T", "xi"}
    assert "may be wrong" in quiet.sentence


def test_a_sufficient_command_is_not_said_to_determine_only_together() -> None:
    found = told(actuator(**PAPER), "chirp", CommandLimits(20.0, None, 20.0))
    assert found.sufficient
    assert "k, T and xi to" in found.sentence
    assert "T and xi together are determined worst: " in found.sentence
    assert "times the noise" in found.sentence


def test_one_parameter_that_is_not_determined_is_named_once() -> None:
    """A play of a thousandth of a degree, beside a core that the command determines."""
    model = actuator(**PAPER, backlash__gap=0.001)
    rows = predicted_experiment(design("standard", CommandLimits(20.0, None, 20.0)).excitation)
    found = assess(model, [rows], NOISE_DEG, catalogue=catalogue())
    assert found.unsure == ("backlash.gap",)
    assert found.sentence.startswith(
        "The command does not determine backlash.gap: raising backlash.gap by"
    )


def test_a_better_command_is_named_within_the_same_limits() -> None:
    model = actuator(**PAPER)
    rows = predicted_experiment(design("sine", CommandLimits(20.0, None, 20.0)).excitation)
    now = assess(model, [rows], NOISE_DEG, catalogue=catalogue())
    better = better_command(model, rows, NOISE_DEG, catalogue=catalogue())
    assert better is not None
    assert better.information.sufficient
    assert max(better.information.sigma.values()) < 0.1 * max(now.sigma.values())
    assert f"servosight excite {better.shape} --angle 20 --rate 125.7" in better.sentence(now)


def test_predicted_sigmas_are_those_of_a_fit(record: Callable[..., Recording]) -> None:
    """The fit estimates its noise from 720 samples, which is good to 1/sqrt(2*720) = 2.6 %."""
    recording = record(6.0, noise_deg=NOISE_DEG, backlash__gap=1.0)
    fit = identify([recording], ["backlash"], catalogue=catalogue(), method="gradient")
    found = assess(
        fit.actuator,
        [recording],
        NOISE_DEG,
        catalogue=catalogue(),
        biases_deg=[fit.biases[0].value],
    )
    assert found.sufficient
    for name, share in found.sigma.items():
        estimate = fit.actuator.parameters[name]
        assert estimate.sigma is not None
        assert share * abs(estimate.value) == pytest.approx(estimate.sigma, rel=0.12), name


def test_information_grows_with_time_and_falls_with_noise() -> None:
    """Four times the time is four times the information: half the sigma, but for the start."""
    model = actuator(k=1.0, T=0.02, xi=0.6, bias=0.0)
    short, long = (told(model, "prbs", CommandLimits(5.0, None, t)) for t in (5.0, 20.0))
    for name in ("k", "T", "xi"):
        assert short.sigma[name] / long.sigma[name] == pytest.approx(2.0, rel=0.15)
    rows = predicted_experiment(design("prbs", CommandLimits(5.0, None, 20.0)).excitation, 120.0)
    loud = assess(model, [rows], 2.0 * NOISE_DEG, catalogue=catalogue())
    np.testing.assert_allclose(loud.per_second, 0.25 * long.per_second)
    assert loud.condition == pytest.approx(long.condition)
    values = long.to_dict()
    assert values["sufficient"] is long.sufficient
    assert len(values["per_second"]) == 3


def test_an_effect_that_the_command_never_meets_is_unsure() -> None:
    """A limit of 500 deg of drive is never reached by 10 deg."""
    model = actuator(k=1.0, T=0.02, xi=0.6, bias=0.0, torque_saturation__limit=500.0)
    found = told(model, "chirp", CommandLimits(10.0, None, 8.0))
    assert found.unsure == ("torque_saturation.limit",)
    assert not np.isfinite(found.sigma["torque_saturation.limit"])
    assert found.to_dict()["relative_sigma"]["torque_saturation.limit"] is None


@pytest.mark.parametrize("wanted", [["T", "xi", "backlash.gap"], ["backlash.gap"], ["T"]])
def test_the_optimal_mix_tells_more_than_any_shape(wanted: list[str]) -> None:
    """By the volume of the wanted parameters' confidence region, and within the limits."""
    model = actuator(k=1.0, T=0.02, xi=0.6, bias=0.0, backlash__gap=1.0)
    limits = CommandLimits(20.0, 300.0, 10.0, centre_deg=3.0)
    best = optimal(model, wanted, limits, catalogue=catalogue(), noise_deg=NOISE_DEG)
    rows = best.design.excitation
    assert np.abs(rows.command_deg - 3.0).max() <= 20.0 + 1e-9
    assert np.abs(np.diff(rows.command_deg)).max() * 250.0 <= 300.0 * (1.0 + 1e-9)
    assert rows.duration_s <= 10.0 + 1e-9

    def volume(found: Information) -> float:
        covariance = np.linalg.inv(found.fisher)
        index = [found.names.index(name) for name in wanted]
        return float(np.linalg.det(covariance[np.ix_(index, index)]))

    for shape in SHAPES:
        assert volume(best.information) < 1.001 * volume(told(model, shape, limits)), shape


def test_optimal_refuses_what_the_model_has_not() -> None:
    model = actuator(k=1.0, T=0.02, xi=0.6, bias=0.0, coulomb_friction__level=0.0)
    limits = CommandLimits(10.0, None, 6.0)
    with pytest.raises(InputError, match=r"expected some of k, T, xi, coulomb_friction\.level"):
        optimal(model, ["gap"], limits, catalogue=catalogue())
    with pytest.raises(InputError, match=r"coulomb_friction\.level = 0"):
        optimal(model, ["coulomb_friction.level"], limits, catalogue=catalogue())
