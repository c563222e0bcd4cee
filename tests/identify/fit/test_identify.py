"""Parameters from recordings: right, reproducible, with a sigma that means what it says."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from servosight.identify.fit import identify
from servosight.models.core import CORE, Estimate
from servosight.models.effects import catalogue

TRUTH = {"k": 1.027, "T": 0.0078, "xi": 0.55, "bias": 0.5}


def assert_near(found: dict[str, Estimate], truth: dict[str, float], share: float = 0.0) -> None:
    """Within four sigma (1 in 16000 by chance), or ``share`` of the truth."""
    for name, value in truth.items():
        one = found[name]
        bound = max(4.0 * (one.sigma or 0.0), share * abs(value))
        print(f"{name}: truth {value:g}, found {one.value:.6g} +- {one.sigma}, bound {bound:.2g}")
        assert abs(one.value - value) <= bound, name


def test_a_linear_fit_loads_nothing_of_scipys_signal() -> None:
    """It takes a second to load, half of what `servosight identify` may take in all."""
    script = (
        "import sys, numpy as np\n"
        "from servosight.identify.fit._identify import identify\n"
        "from servosight.models.core._recording import Recording\n"
        "from servosight.models.effects._registry import catalogue\n"
        "time_s = np.arange(0.0, 4.0, 0.01)\n"
        "command = 10.0 * np.sign(np.sin(3.0 * time_s))\n"
        "angle = command + np.random.default_rng(1).normal(0.0, 1.0, time_s.size)\n"
        "record = Recording('made', time_s, command, time_s, angle)\n"
        "identify([record], [], catalogue=catalogue())\n"
        "assert 'scipy.signal' not in sys.modules\n"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("method", ["gradient", "combination"])
def test_the_papers_servo(method: str, record: Any) -> None:
    """k = 1.027, T = 7.8 ms, xi = 0.55; sigma of k below 0.1 %, of T and xi below 2 %."""
    found = identify([record(10.0)], [], catalogue=catalogue(), method=method)
    parameters = dict(found.actuator.parameters)
    assert_near(parameters, TRUTH)
    for name, share in (("k", 1e-3), ("T", 0.02), ("xi", 0.02)):
        sigma = parameters[name].sigma
        assert sigma is not None
        assert sigma < share * TRUTH[name]
    # 1200 samples: the rmse scatters by 1 / sqrt(2400) = 2 %.
    assert found.rmse_deg == pytest.approx(0.03, rel=0.08)
    assert found.samples == 1200
    assert found.method == method


@pytest.mark.parametrize("method", ["gradient", "combination"])
@pytest.mark.parametrize(
    "effect",
    [{"backlash.gap": 1.5}, {"torque_saturation.limit": 5.0}, {"coulomb_friction.level": 0.9}],
    ids=lambda effect: next(iter(effect)),
)
def test_each_method_recovers_an_effect(method: str, effect: dict[str, float], record: Any) -> None:
    (name,) = effect
    recording = record(4.0, **{name.replace(".", "__"): effect[name]})
    found = identify([recording], [name.split(".")[0]], catalogue=catalogue(), method=method)
    assert_near(dict(found.actuator.parameters), {**TRUTH, **effect}, 0.002)
    assert found.rmse_deg == pytest.approx(0.03, rel=0.08)


def test_a_negative_gain(record: Any) -> None:
    found = identify([record(6.0, k=-0.8)], [], catalogue=catalogue())
    assert_near(dict(found.actuator.parameters), {**TRUTH, "k": -0.8})


def test_the_same_seed_gives_the_same_result(record: Any) -> None:
    recording = record(2.0)
    one, two = (
        identify([recording], ["backlash"], catalogue=catalogue(), seed=3) for _ in range(2)
    )
    assert one.actuator == two.actuator
    assert one.evaluations == two.evaluations
    np.testing.assert_array_equal(one.history, two.history)


def test_sigma_is_calibrated(record: Any) -> None:
    """100 noises: for each of k, T, xi the sum of ((found - truth) / sigma)^2 is chi-square of 100.

    Its standard deviation is sqrt(200) = 14; the bounds are three of that about 100, which a sigma
    too large by a third or too small by a fifth does not keep.
    """
    deviations = []
    for seed in range(100):
        found = identify([record(2.0, seed)], [], catalogue=catalogue(), method="gradient").actuator
        estimates = {name: found.parameters[name] for name in ("k", "T", "xi")}
        assert all(one.sigma for one in estimates.values())
        deviations.append([(e.value - TRUTH[n]) / (e.sigma or 1.0) for n, e in estimates.items()])
    squares = np.sum(np.square(deviations), axis=0)
    print(f"chi-square {squares.round(1)} of 100, worst {np.abs(deviations).max():.2f} sigma")
    assert np.all(np.abs(squares - 100) < 3 * math.sqrt(200))
    assert np.abs(deviations).max() < 4.5


def test_several_recordings_share_the_physics_and_keep_their_biases(record: Any) -> None:
    biases = (0.5, -3.0, 7.0)
    recordings = [
        record(4.0, seed, bias=bias, initial_angle=bias) for seed, bias in enumerate(biases)
    ]
    found = identify(recordings, [], catalogue=catalogue(), method="gradient")
    assert_near(dict(found.actuator.parameters), {name: TRUTH[name] for name in ("k", "T", "xi")})
    for one, truth in zip(found.biases, biases, strict=True):
        assert one.sigma is not None
        assert abs(one.value - truth) < 4.0 * one.sigma
    alone = identify(recordings[:1], [], catalogue=catalogue(), method="gradient")
    joint_sigma = found.actuator.parameters["T"].sigma
    alone_sigma = alone.actuator.parameters["T"].sigma
    assert joint_sigma is not None
    assert alone_sigma is not None
    # Three times the data: sigma falls by sqrt(3), with the noises' own scatter.
    assert joint_sigma == pytest.approx(alone_sigma / math.sqrt(3), rel=0.15)
    assert isinstance(found.to_dict()["parameters"]["bias"], list)
    assert isinstance(alone.to_dict()["parameters"]["bias"], dict)


def test_recordings_at_other_gains_and_loads_share_one_set_of_parameters(record: Any) -> None:
    """Four times the gain halves T and xi and quarters each torque; half the load halves gravity.

    The rows are written out by hand: the scaling under test is not used to make the data.
    """
    one = record(6.0, 1, T=0.03, xi=0.8, coulomb_friction__level=2.0, gravity_load__cosine=3.0)
    other = record(6.0, 2, T=0.015, xi=0.4, coulomb_friction__level=0.5, gravity_load__cosine=0.375)
    other = replace(other, relative_gain=4.0, relative_load=0.5)
    effects = ["coulomb_friction", "gravity_load"]
    found = identify([one, other], effects, catalogue=catalogue(), method="gradient").actuator
    truth = {"T": 0.03, "xi": 0.8, "coulomb_friction.level": 2.0, "k": 1.027}
    assert_near(dict(found.parameters), truth)


def test_samples_count_by_their_sigma(record: Any) -> None:
    """Half the samples are useless (3 deg) and say so: the fit is as good as on the other half."""
    recording = record(6.0)
    bad = np.arange(recording.time_s.size) % 2 == 1
    noise = np.random.default_rng(1).normal(0.0, 3.0, recording.time_s.size)
    mixed = replace(
        recording,
        angle_deg=recording.angle_deg + np.where(bad, noise, 0.0),
        sigma_deg=np.where(bad, 3.0, 0.03),
    )
    found = identify([mixed], [], catalogue=catalogue(), method="gradient").actuator
    half = replace(recording, time_s=recording.time_s[~bad], angle_deg=recording.angle_deg[~bad])
    clean = identify([half], [], catalogue=catalogue(), method="gradient").actuator
    for name in ("k", "T", "xi"):
        sigma = clean.parameters[name].sigma
        assert sigma is not None
        assert abs(found.value(name) - clean.value(name)) < 0.5 * sigma


def test_parameters_stay_within_their_bounds(record: Any) -> None:
    """Pure noise about a constant: whatever comes out is a legal model."""
    recording = record(3.0, k=0.0)
    found = identify([recording], ["backlash", "dead_time"], catalogue=catalogue())
    for parameter in CORE:
        assert parameter.low <= found.actuator.value(parameter.name) <= parameter.high
    for name in ("backlash", "dead_time"):
        for parameter in catalogue()[name].parameters:
            value = found.actuator.value(f"{name}.{parameter.name}")
            assert parameter.low <= value <= parameter.high
    json.dumps(found.to_dict(), allow_nan=False)


def test_a_single_sine_does_not_tell_T_from_xi(record: Any) -> None:
    """The paper's own signal gives two numbers, gain and phase: k, T and xi are three.

    What it does tell is the phase lag 2 xi T; T or xi alone is unknown to 10 % or worse, or null.
    """
    whole = record(9.0, kind="sine")
    steady = whole.time_s > 1.0  # the start is a transient, and tells more
    sine = replace(whole, time_s=whole.time_s[steady], angle_deg=whole.angle_deg[steady])
    found = identify([sine], [], catalogue=catalogue(), method="gradient")
    T, xi = found.actuator.parameters["T"], found.actuator.parameters["xi"]
    print(f"T {T.value:.5f} +- {T.sigma}, xi {xi.value:.3f} +- {xi.sigma}")
    assert 2 * xi.value * T.value == pytest.approx(2 * 0.55 * 0.0078, rel=0.02)
    unknown = [one for one in (T, xi) if one.sigma is None or one.sigma > 0.1 * abs(one.value)]
    assert len(unknown) == 2
    for one, name in ((T, "T"), (xi, "xi")):
        if one.sigma is None:
            assert any(warning.startswith(name) for warning in found.warnings)


@pytest.mark.parametrize("seed", range(3))
def test_a_limit_that_is_never_reached_does_no_harm(seed: int, record: Any) -> None:
    """The command jumps by 17.2 deg at most: the limit is found no lower, and k, T, xi stay."""
    recording = record(4.0, seed)
    found = identify([recording], ["torque_saturation"], catalogue=catalogue(), method="gradient")
    limit = found.actuator.parameters["torque_saturation.limit"]
    assert math.isfinite(limit.value)
    assert limit.value > 0.99 * np.abs(np.diff(recording.command_deg)).max()
    warned = any("torque_saturation.limit" in warning for warning in found.warnings)
    assert warned == (limit.sigma is None)
    assert_near(dict(found.actuator.parameters), TRUTH)


def test_json_is_what_interfaces_fix(record: Any) -> None:
    found = identify([record(3.0)], ["backlash"], catalogue=catalogue(), method="gradient")
    answer = json.loads(json.dumps(found.to_dict(), allow_nan=False))
    assert answer.keys() >= {
        "schema",
        "parameters",
        "rmse_deg",
        "noise_deg",
        "floor_deg",
        "samples",
        "method",
        "seconds",
        "stopped",
        "warnings",
    }
    assert answer["schema"] == 1
    assert list(answer["parameters"]) == ["k", "T", "xi", "backlash.gap", "bias"]
    for one in answer["parameters"].values():
        assert one.keys() == {"value", "sigma", "unit"}
    assert answer["parameters"]["T"]["unit"] == "s"
    assert answer["floor_deg"] >= answer["noise_deg"]
    assert answer["method"] == "gradient"
    assert answer["stopped"]


def test_the_tolerance_raises_the_floor(record: Any) -> None:
    """floor = hypot(noise, tolerance)."""
    found = identify([record(3.0)], [], catalogue=catalogue(), method="gradient", tolerance=0.4)
    assert found.floor_deg == pytest.approx(math.hypot(found.noise_deg, 0.4))
