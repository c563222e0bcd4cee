"""The paper's eq. 2: conversions both ways, and fits of it beside its bias under noise."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from servosight.app.main import main
from servosight.identify.discrete._discrete import (
    METHODS,
    by_arx,
    by_output_error,
    simulate,
    to_linear,
)
from servosight.models.core import InputError
from servosight.models.plant import TRANSFORMS, Difference, Linear, to_difference

PAPER = Linear(1.027, 0.0078, 0.55)


def assert_near(found: Linear, truth: Linear, share: float) -> None:
    """Each of k, T and xi within a share of its truth."""
    ours, theirs = ([one.k, one.T, one.xi] for one in (found, truth))
    np.testing.assert_allclose(ours, theirs, rtol=share, atol=1e-9)


def test_the_papers_numbers_are_bilinear_at_10_ms() -> None:
    """a1, a2, b0, b2 as printed, within what the rounding of T and xi to two digits lets through.

    T to 0.6 % and xi to 0.9 % move b0 by 0.9 %, a1 by 0.01 and a2 by 0.005.
    """
    found = to_difference(PAPER, 0.01, "tustin")
    assert found.a1 == pytest.approx(-0.56, abs=0.01)
    assert found.a2 == pytest.approx(0.33, abs=0.005)
    assert found.b0 == pytest.approx(0.198, rel=0.009)
    assert found.b2 == found.b0


@pytest.mark.parametrize("transform", ["zoh", "matched"])
def test_no_other_sampling_gives_them(transform: str) -> None:
    found = to_difference(PAPER, 0.01, transform)
    assert abs(found.a1 + 0.56) > 0.05
    assert abs(found.b0 - 0.198) > 0.05


def test_the_printed_b1_is_a_misprint() -> None:
    """As printed k is 0.956; with the bilinear 1 : 2 : 1 it is the paper's 1.027."""
    printed = Difference(0.01, -0.56, 0.33, 0.198, 0.34, 0.198)
    assert to_linear(printed).k == pytest.approx(0.956, abs=5e-4)
    mended = to_linear(Difference(0.01, -0.56, 0.33, 0.198, 0.395, 0.198))
    assert_near(mended, PAPER, 0.01)
    assert mended.k == pytest.approx(1.027, abs=5e-4)


def test_the_bilinear_transform_is_controls() -> None:
    import control

    system = control.tf([PAPER.k], [PAPER.T**2, 2.0 * PAPER.xi * PAPER.T, 1.0])
    theirs = control.sample_system(system, 0.01, method="bilinear")
    ours = to_difference(PAPER, 0.01)
    np.testing.assert_allclose([ours.b0, ours.b1, ours.b2], theirs.num[0][0], rtol=1e-9)
    np.testing.assert_allclose([1.0, ours.a1, ours.a2], theirs.den[0][0], rtol=1e-9)


@pytest.mark.parametrize("transform", TRANSFORMS)
@given(k=st.floats(-3.0, 3.0), T=st.floats(0.003, 0.2), xi=st.floats(0.1, 3.0))
def test_there_and_back(transform: str, k: float, T: float, xi: float) -> None:
    """At 5 ms, any servo that turns less than half round between two samples (T over 1.6 ms)."""
    found = to_linear(to_difference(Linear(k, T, xi), 0.005, transform), transform)
    assert_near(found, Linear(k, T, xi), 1e-5)


def test_a_sampled_pole_that_no_servo_has_is_refused() -> None:
    with pytest.raises(InputError, match="sample faster"):
        to_linear(Difference(0.01, 0.9, 0.1, 1.0, 0.0, 0.0), "zoh")
    with pytest.raises(InputError, match="stable"):
        to_linear(Difference(0.01, -2.5, 1.2, 1.0, 0.0, 0.0))


def held(seed: int, noise_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """2000 held random levels at 10 ms and scipy's continuous answer to them, with noise."""
    rng = np.random.default_rng(seed)
    command = np.repeat(rng.uniform(-20.0, 20.0, 400), 5)
    fine = signal.lti([PAPER.k], [PAPER.T**2, 2.0 * PAPER.xi * PAPER.T, 1.0])
    time_s = np.arange(20_000) * 1e-3
    _, angle, _ = signal.lsim(fine, np.repeat(command, 10), time_s, interp=False)
    return command, angle[::10] + rng.normal(0.0, noise_deg, command.size)


@pytest.mark.parametrize("method", METHODS)
def test_without_noise_every_method_is_exact(method: str) -> None:
    """A held command sampled as it is sent: zero-order hold is no approximation."""
    found = to_linear(METHODS[method](*held(1, 0.0), 0.01), "zoh")
    assert_near(found, PAPER, 1e-6)


def test_noise_biases_arx_and_not_the_others() -> None:
    """20 noises of 1 deg: ARX's T is off by many times its scatter, the others' by chance at most.

    The bound on a mean of 20 is four of its standard deviations.
    """
    found = {name: [] for name in METHODS}
    for seed in range(20):
        command, angle = held(seed, 1.0)
        for name, fit in METHODS.items():
            found[name].append(to_linear(fit(command, angle, 0.01), "zoh").T)
    off = {name: np.mean(values) - PAPER.T for name, values in found.items()}
    scatter = {name: np.std(values) / np.sqrt(20) for name, values in found.items()}
    print({name: (off[name], scatter[name]) for name in METHODS})
    assert abs(off["arx"]) > 4.0 * scatter["arx"]
    for name in ("instruments", "output_error"):
        assert abs(off[name]) < 4.0 * scatter[name]
        assert abs(off[name]) < 0.3 * abs(off["arx"])


def test_output_error_fits_the_angle_best() -> None:
    command, angle = held(3, 1.0)

    def left(model: Difference) -> float:
        return float(np.sum((angle - simulate(model, command)) ** 2))

    assert left(by_output_error(command, angle, 0.01)) <= left(by_arx(command, angle, 0.01))


def test_the_command_line_gives_eq_2_as_well(tmp_path: Path, record: Any) -> None:
    """`identify --json`: the coefficients at the recording's own sample time, by Tustin."""
    source, answer = tmp_path / "log.csv", tmp_path / "model.json"
    one = record(3.0)
    at = np.searchsorted(one.command_time_s, one.time_s, side="right") - 1
    table = np.column_stack([one.time_s, one.command_deg[at], one.angle_deg])
    head = "time_s,command_deg,angle_deg"
    np.savetxt(source, table, delimiter=",", header=head, comments="", fmt="%.9g")
    assert main(["identify", str(source), "--method", "gradient", "--json", str(answer)]) == 0
    told = json.loads(answer.read_text())
    assert list(told["discrete"]) == ["sample_time_s", "a1", "a2", "b0", "b1", "b2"]
    assert told["discrete"]["sample_time_s"] == pytest.approx(1 / 120, rel=1e-5)
    back = to_linear(Difference(**told["discrete"]))
    values = (told["parameters"][name]["value"] for name in ("k", "T", "xi"))
    assert_near(back, Linear(*values), 1e-9)
