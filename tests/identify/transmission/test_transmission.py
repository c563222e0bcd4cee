"""Ratio and play between horn and surface. Truth: the MuJoCo twin and the four-bar's geometry."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from servosight.identify.transmission import Transmission, transmission, transmissions
from servosight.identify.transmission._play import driven
from servosight.models.core import InputError, Recording
from servosight.scenarios.scenario import Scenario, with_effects
from servosight.sim.run import run

OFFSET_DEG = 25.0
GAP_DEG = 0.5


def views(
    settings: Mapping[str, float], noise_deg: float, duration_s: float = 20.0
) -> list[Recording]:
    """Surface and horn of the twin at 120 Hz, with noise."""
    scenario = with_effects(Scenario(duration_s=duration_s, seed=1), (), settings)
    true = run(scenario.servo.bench(), scenario.effects, scenario.excitation())
    time_s = np.arange(0.01, true.time_s[-1], 1.0 / 120.0)
    rng = np.random.default_rng(5)
    sigma = np.full(time_s.size, noise_deg)
    command = np.interp(time_s, true.time_s, true.command_deg)
    angles = [
        np.interp(time_s, true.time_s, angle) + noise_deg * rng.standard_normal(time_s.size)
        for angle in (true.surface_deg, true.motor_deg)
    ]
    return [
        Recording("run", time_s, command, time_s, angles[0], sigma),
        Recording("run (horn)", time_s, command, time_s, angles[1], sigma, side="horn"),
    ]


def four_bar(horn_deg: np.ndarray, ratio: float) -> np.ndarray:
    """Slope of sin y = ratio (sin(h + offset) - sin offset)."""
    offset = np.radians(OFFSET_DEG)
    turned = np.radians(horn_deg) + offset
    surface = np.arcsin(ratio * (np.sin(turned) - np.sin(offset)))
    return ratio * np.cos(turned) / np.cos(surface)


@pytest.mark.parametrize("noise_deg", [0.0005, 0.02])
def test_the_ratio_of_a_linkage_is_found_over_the_angle(noise_deg: float) -> None:
    """Within four sigma at all nine places; nothing but noise remains, by 5 %."""
    settings = {"linkage_geometry.horn": 1.1, "linkage_geometry.offset": OFFSET_DEG}
    found = transmission(*views(settings, noise_deg))
    error = found.ratio - four_bar(found.horn_deg, 1.1)
    assert np.all(np.abs(error) < 4.0 * found.ratio_sigma)
    assert np.all(found.ratio_sigma < 0.01)
    assert found.play_deg is None
    assert found.rmse_deg < 1.05 * found.noise_deg
    (line, *_) = found.plot().lines
    assert np.array_equal(line.get_ydata(), found.ratio)


def test_play_is_told_from_the_linkage_before_it() -> None:
    """The gap within 1 %: the twin's stops give way by so much. The ratio within four sigma."""
    settings = {"backlash.gap": GAP_DEG, "linkage_geometry.offset": OFFSET_DEG}
    found = transmission(*views(settings, 0.005))
    assert found.play_deg is not None
    assert found.play_deg.value == pytest.approx(GAP_DEG, rel=0.01)
    error = found.ratio - four_bar(found.horn_deg, 1.0)
    assert np.all(np.abs(error) < 4.0 * found.ratio_sigma)
    assert "play of 0.49" in found.sentence or "play of 0.50" in found.sentence


def test_two_parts_that_are_one_have_a_ratio_of_one_and_no_play() -> None:
    found = transmission(*views({}, 0.02))
    assert np.all(np.abs(found.ratio - 1.0) < 4.0 * found.ratio_sigma)
    assert found.play_deg is None
    assert "no play is seen" in found.sentence
    assert "(horn at" not in found.sentence  # one ratio for all angles


def test_what_does_not_suffice_is_refused_and_left_out() -> None:
    surface, horn = views({}, 0.02, duration_s=2.0)
    early = Recording(
        "run", surface.time_s, surface.command_deg, surface.time_s[:50], surface.angle_deg[:50]
    )
    with pytest.raises(InputError, match="in 50 samples, expected 100 or more"):
        transmission(early, horn)
    still = Recording(
        "run", horn.time_s, horn.command_deg, horn.time_s, np.zeros(horn.time_s.size), side="horn"
    )
    assert not transmissions([early, horn])
    assert not transmissions([surface, still])
    (found,) = transmissions([surface, horn])
    assert isinstance(found, Transmission)


@given(
    st.lists(st.floats(-90.0, 90.0), min_size=2, max_size=50),
    st.floats(0.0, 20.0),
)
def test_the_driven_part_stays_within_the_play_and_moves_only_when_pushed(
    driver: list[float], gap: float
) -> None:
    angles = np.array(driver)
    (places,), _ = driven(angles, np.array([gap]))
    assert np.all(np.abs(places - angles) <= 0.5 * gap + 1e-9)
    moved = np.diff(places)
    at_stop = np.isclose(np.abs(places - angles)[1:], 0.5 * gap, atol=1e-9)
    assert np.all((moved == 0.0) | at_stop)
