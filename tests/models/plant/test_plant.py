"""What the plant promises besides accuracy: timing of rows and samples, exposure, sticking."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from servosight.models.core import Array, Recording
from servosight.models.effects import catalogue
from servosight.models.plant import Plant, Stimulus
from servosight.models.plant.kernel._integrator import FULL_STEP

T, XI = 0.0078, 0.55


@pytest.fixture(scope="module")
def plant() -> Plant:
    return Plant.of(catalogue())


def row_of(plant: Plant, **values: float) -> Array:
    """A neutral row with k, T, xi and what ``values`` say (``effect__parameter``)."""
    row = np.array(plant.layout.neutral_row())
    row[:3] = 1.0, T, XI
    for name, value in values.items():
        row[plant.index(name.replace("__", "."))] = value
    return row


def step_answer(t: Array) -> Array:
    """Answer of the linear core to a unit step at t = 0, by hand (underdamped)."""
    t = np.maximum(t, 0.0)
    omega = np.sqrt(1 - XI**2) / T
    wave = np.cos(omega * t) + XI / np.sqrt(1 - XI**2) * np.sin(omega * t)
    return np.asarray(1.0 - np.exp(-XI * t / T) * wave)


def test_irregular_rows_are_held(plant: Plant) -> None:
    """Truth: a sum of step answers. Bound 1e-6 deg: the core is exact, only output interpolates."""
    times = np.array([0.0, 0.01, 0.0103, 0.0555, 0.3])
    command = np.array([0.0, 10.0, -5.0, 7.0, 7.0])
    samples = np.arange(0.0, 0.4, 0.0009)
    truth = sum(
        jump * step_answer(samples - at)
        for jump, at in zip(np.diff(command), times[1:], strict=True)
    )
    answer = plant.simulate(row_of(plant), Stimulus(times, command, False, samples, np.ones(1)))
    np.testing.assert_allclose(answer, truth, atol=1e-6)


def test_a_minute_of_a_steep_torque_line_is_simulated_to_its_end(plant: Plant) -> None:
    """It asks for steps of a twenty-fifth of T. Truth: steps a tenth as long; bound 1e-3 deg."""
    times = np.arange(0.0, 60.0, 0.7)
    command = 20.0 * np.sign(np.sin(times))
    samples = np.arange(0.0, 60.0, 0.01)
    row = row_of(plant, speed_limit__stall=30.6, speed_limit__no_load_speed=189.3)
    row[1:3] = 0.0254, 0.7
    stimulus = Stimulus(times, command, False, samples, np.ones(1))
    answer = plant.simulate(row, stimulus)
    truth = plant.simulate(row, replace(stimulus, samples_s=samples[:300]), step_s=1e-4)
    assert np.isfinite(answer).all()
    np.testing.assert_allclose(answer[:300], truth, atol=1e-3)


def test_linear_hold_joins_rows_by_lines(plant: Plant) -> None:
    """A ramp of 100 deg/s is followed with the lag 2 xi T once the transient is gone."""
    times, command = np.array([0.0, 1.0]), np.array([0.0, 100.0])
    samples = np.arange(0.5, 1.0, 0.003)
    whole = np.concatenate([[0.0], samples])
    answer = plant.simulate(row_of(plant), Stimulus(times, command, True, whole, np.ones(1)))[1:]
    np.testing.assert_allclose(answer, 100.0 * (samples - 2 * XI * T), atol=1e-7)


@pytest.mark.parametrize("linear", [False, True])
def test_the_first_row_holds_before_it_and_the_last_after(plant: Plant, linear: bool) -> None:
    """Resting at the first row's value a second before it, at the last one's a second after."""
    times, command = np.array([1.0, 1.2, 1.4]), np.array([5.0, 9.0, -3.0])
    samples = np.array([0.0, 0.5, 0.999, 2.0, 3.0])
    row = row_of(plant, initial_angle=5.0)
    answer = plant.simulate(row, Stimulus(times, command, linear, samples, np.ones(1)))
    np.testing.assert_allclose(answer, [5.0, 5.0, 5.0, -3.0, -3.0], atol=1e-6)


def test_a_delay_is_a_fraction_of_a_step(plant: Plant) -> None:
    """Truth: the same curve, shifted; 0.1 us of delay moves 20 deg by what its speed says."""
    times, command = np.array([0.0, 0.05]), np.array([0.0, 20.0])
    samples = np.arange(0.0, 0.15, 0.0007)
    stimulus = Stimulus(times, command, False, samples, np.ones(1))
    for delay in (1e-7, 0.000123, 0.0101, 0.03777):
        answer = plant.simulate(row_of(plant, dead_time__delay=delay), stimulus)
        np.testing.assert_allclose(answer, 20.0 * step_answer(samples - 0.05 - delay), atol=1e-5)


@pytest.mark.parametrize("gap", [0.0, 0.5])
def test_exposure_averages_the_angle(plant: Plant, gap: float) -> None:
    """Truth: the mean of 400 samples over each exposure of 4 ms.

    Bound: five Gauss nodes err by at most 0.0138 on a kink (s - c)+ in [-1, 1]. A gap of 0.5 deg
    is passed from a reversal at a = 4264 deg/s^2 and left at sqrt(2 a gap) = 65 deg/s; times half
    the exposure that is 0.0018 deg. Without a gap the motion is smooth: 1e-5 deg.
    """
    rows = np.arange(0.0, 1.0, 0.01)
    command = 12.0 * np.sin(2 * np.pi * 3.0 * rows)
    time_s = np.arange(0.1, 0.9, 0.01)
    recording = Recording("r", rows, command, time_s, np.zeros(time_s.size), exposure_s=0.004)
    row = row_of(plant, backlash__gap=gap)
    seen = plant.simulate(row, Stimulus.of(recording))
    inside = 0.004 * ((np.arange(400) + 0.5) / 400 - 0.5)
    # Start both at one instant, so that the initial state means the same.
    start = Stimulus.of(recording).samples_s[0]
    dense = np.concatenate([[start], np.sort((time_s[:, None] + inside).ravel())])
    dense[0] = min(dense[0], start)
    answer = plant.simulate(row, Stimulus(rows, command, False, dense, np.ones(1)))
    mean = answer[1:].reshape(-1, 400).mean(axis=1)
    print(f"gap {gap}: {np.abs(seen - mean)[3:].max():.2e} deg")
    bound = 0.0138 * 0.002 * np.sqrt(2 * 12.0 * (6 * np.pi) ** 2 * gap) + 1e-5
    assert np.abs(seen - mean)[3:].max() < bound


@pytest.mark.parametrize("rest_deg", [-0.99, 0.4, 0.99])
def test_a_surface_that_rests_within_its_play_stays_until_it_is_pushed(
    plant: Plant, rest_deg: float
) -> None:
    """The motor is where the command holds it, not where the surface is: from there it would swing
    back beyond the other end of the play, and take the surface along."""
    rows = np.array([0.0, 0.5])
    samples = np.arange(0.0, 1.0, 0.002)
    row = row_of(plant, backlash__gap=2.0, xi=0.2, initial_angle=rest_deg)
    surface = plant.simulate(row, Stimulus(rows, np.array([0.0, 9.0]), False, samples, np.ones(1)))
    np.testing.assert_allclose(surface[samples < 0.5], rest_deg, atol=1e-12)
    assert surface[-1] > 5.0


def test_a_surface_outside_the_play_is_pushed_from_the_first_instant(plant: Plant) -> None:
    """The motor begins at the end of the play that the command pulls against."""
    samples = np.arange(0.0, 0.6, 0.002)
    still = Stimulus(np.zeros(1), np.zeros(1), False, samples, np.ones(1))
    loose = row_of(plant, backlash__gap=2.0, xi=1.5, initial_angle=6.0)
    tight = row_of(plant, xi=1.5, initial_angle=5.0)
    pushed = plant.simulate(loose, still)
    np.testing.assert_allclose(pushed, plant.simulate(tight, still) + 1.0, atol=1e-6)


def test_a_negative_gain_mirrors(plant: Plant) -> None:
    times, command = np.array([0.0, 0.05, 0.1]), np.array([0.0, 20.0, -4.0])
    stimulus = Stimulus(times, command, False, np.arange(0.0, 0.2, 0.001), np.ones(1))
    for own in ({}, {"coulomb_friction__level": 1.0}, {"backlash__gap": 1.0}):
        up = plant.simulate(row_of(plant, k=0.9, **own), stimulus)
        down = plant.simulate(row_of(plant, k=-0.9, **own), stimulus)
        np.testing.assert_allclose(up, -down, atol=1e-12)


def test_friction_sticks_exactly_below_breakaway(plant: Plant) -> None:
    """A ramp of 1 deg/s that stops at 0.99 of the level: the angle is 0, not nearly 0."""
    times, command = np.array([0.0, 0.99, 5.0]), np.array([0.0, 0.99, 0.99])
    samples = np.arange(0.0, 5.0, 0.01)
    row = row_of(plant, coulomb_friction__level=1.0)
    stuck = plant.simulate(row, Stimulus(times, command, True, samples, np.ones(1)))
    assert np.all(stuck == 0.0)
    loose = row_of(plant, coulomb_friction__level=0.98)
    assert np.ptp(plant.simulate(loose, Stimulus(times, command, True, samples, np.ones(1)))) > 0.0


def test_friction_breaks_away_at_its_level(plant: Plant) -> None:
    """Truth: under 1 deg/s the surface leaves at 1.0 s. Sampled at 1 ms; at 1.001 s it has moved
    by (1 deg/s) t^3 / (6 T^2) = 2.7e-6 deg."""
    times, command = np.array([0.0, 2.0]), np.array([0.0, 2.0])
    samples = np.arange(0.0, 1.2, 0.001)
    row = row_of(plant, coulomb_friction__level=1.0)
    angle = plant.simulate(row, Stimulus(times, command, True, samples, np.ones(1)))
    assert np.all(angle[samples <= 1.0] == 0.0)
    assert angle[1001] == pytest.approx(1e-9 / (6 * T**2), rel=0.05)


def test_friction_does_not_chatter(plant: Plant) -> None:
    """Stopped after a step, it stays to the last bit, within the level of the command."""
    times, command = np.array([0.0, 0.05]), np.array([0.0, 20.0])
    samples = np.arange(0.3, 1.0, 0.0003)
    whole = np.concatenate([[0.0], samples])
    row = row_of(plant, coulomb_friction__level=0.8)
    rest = plant.simulate(row, Stimulus(times, command, False, whole, np.ones(1)))[1:]
    assert np.unique(rest).size == 1
    assert abs(rest[0] - 20.0) <= 0.8


@pytest.mark.parametrize(
    ("command_deg", "rate", "limit"), [(20.0, 13_500.0, 4.354), (40.0, 73_000.0, 4.363)]
)
def test_a_weight_that_a_limited_drive_just_holds_does_not_chatter(
    plant: Plant, command_deg: float, rate: float, limit: float
) -> None:
    """At rest where drive and friction hold the weight, as the command turns round: within a step
    both clips of the drive are passed, and where the motion is stopped lies behind the first.
    Taken at once they are some 3,600 steps; looked for over the whole step they were 14,000 to
    25,000. Truth: steps of a tenth."""
    times = np.arange(0.0, 4.0, 0.01)
    command = np.where(times % 1.0 < 0.5, -command_deg, command_deg)
    stimulus = Stimulus(times, command, False, times, np.ones(1))
    row = row_of(
        plant, T=0.0128, xi=0.95, rate_limit__rate=rate, current_limit__limit=limit,
        stribeck_friction__excess=0.3, stribeck_friction__speed=15.0,
        directional_friction__motor=0.1, gravity_load__sine=16.7,
    )  # fmt: skip
    angle, taken = plant.simulate_counted(row, stimulus)
    truth = plant.simulate(row, stimulus, 0.1 * 0.0128 / 5.0)
    assert taken is not None
    assert taken[0] < FULL_STEP * 5000
    assert np.abs(angle - truth).max() < 0.01


def test_a_held_command_in_many_rows_is_one_command(plant: Plant) -> None:
    """Rows that repeat a value change nothing, with friction and play on."""
    own = {"coulomb_friction__level": 0.8, "backlash__gap": 1.0, "torque_saturation__limit": 5.0}
    samples = np.arange(0.0, 0.3, 0.0011)
    few = np.array([0.0, 0.05, 0.15]), np.array([0.0, 20.0, -3.0])
    times = np.arange(0.0, 0.3, 0.001)
    many = times, few[1][np.searchsorted(few[0], times + 1e-9, side="right") - 1]
    one, other = (
        plant.simulate(row_of(plant, **own), Stimulus(*rows, False, samples, np.ones(1)))
        for rows in (few, many)
    )
    assert np.abs(one - other).max() < 2e-4


def test_the_wrong_width_is_refused(plant: Plant) -> None:
    stimulus = Stimulus(np.zeros(1), np.zeros(1), False, np.arange(3.0), np.ones(1))
    with pytest.raises(ValueError, match="expected"):
        plant.simulate(np.zeros(5), stimulus)


@pytest.mark.parametrize("early_s", [1e-13, 7e-10, 1e-7, 1e-4])
def test_a_first_sample_just_before_the_first_row_changes_nothing(
    plant: Plant, early_s: float
) -> None:
    """A clock that begins before the command: the servo rests there, so equal to 1e-9 deg."""
    times, command = np.array([0.0, 0.1, 0.2]), np.array([0.0, 5.0, -5.0])
    samples = np.arange(0.0, 0.3, 0.005)
    shifted = samples.copy()
    shifted[0] -= early_s
    row = row_of(plant, coulomb_friction__level=0.2)
    whole, early = (
        plant.simulate(row, Stimulus(times, command, False, at, np.ones(1)))
        for at in (samples, shifted)
    )
    np.testing.assert_allclose(early, whole, atol=1e-9)


def test_the_horn_turns_before_linkage_and_shaft(plant: Plant) -> None:
    """Behind a play the surface is the play of the horn; behind a loose shaft it swings further.

    Truth: the horn of a servo with a play is that of the servo without; the play operator of its
    angle at a fine step is the surface, to the 1e-4 deg that its own sampling leaves. On a shaft
    of 30 Hz a surface that swings at 4 Hz goes 1 / (1 - (4 / 30)^2) = 1.0181 times as far.
    """
    times = np.arange(0.0, 0.4, 0.004)
    command = 10.0 * np.sin(2 * np.pi * 4.0 * times)
    samples = np.arange(0.0, 0.4, 1e-4)
    seen = Stimulus(times, command, False, samples, np.ones(1))
    horn = replace(seen, horn=True)
    plain, loose = row_of(plant), row_of(plant, backlash__gap=1.0)

    np.testing.assert_array_equal(plant.simulate(plain, horn), plant.simulate(plain, seen))
    motor = plant.simulate(loose, horn)
    np.testing.assert_allclose(motor, plant.simulate(plain, seen), atol=1e-6)
    held, surface = 0.0, []
    for angle in motor:
        held = min(max(held, angle - 0.5), angle + 0.5)
        surface.append(held)
    np.testing.assert_allclose(plant.simulate(loose, seen), surface, atol=1e-4)

    shaft = row_of(
        plant,
        flexible_shaft__frequency=30.0,
        flexible_shaft__damping=0.01,
        flexible_shaft__inertia_ratio=0.3,
    )
    further = np.ptp(plant.simulate(shaft, seen)) / np.ptp(plant.simulate(shaft, horn))
    assert abs(further - 1.0181) < 0.002


def test_a_motion_that_runs_away_is_given_up(plant: Plant) -> None:
    """A hinge that pushes outward by the cube of the angle leaves any range within milliseconds."""
    times, command = np.array([0.0]), np.array([20.0])
    samples = np.arange(0.0, 1.0, 0.001)
    row = row_of(plant, hinge_hardening__cubic=-0.1)
    answer = plant.simulate(row, Stimulus(times, command, False, samples, np.ones(1)))
    lost = int(np.isnan(answer).argmax())
    assert 2 < lost < 100
    assert np.all(np.isnan(answer[lost:]))
    assert np.all(np.abs(answer[: lost - 2]) < 1e9)


def test_a_motion_begins_anew_where_it_is_told(plant: Plant) -> None:
    """Behind a restart the answer is that of a recording which begins there with this motion.

    The sample at the restart is the last of what was predicted before it.
    """
    samples = np.arange(0.0, 0.1, 0.001)
    times, command = np.array([0.0, 0.021]), np.array([0.0, 10.0])
    whole = Stimulus(
        times, command, False, samples, np.ones(1), restarts=np.array([[0.05], [3.0], [200.0]])
    )
    begun = samples[samples >= 0.05]
    alone = replace(whole, samples_s=begun, restarts=np.zeros((3, 0)))
    plain = replace(whole, restarts=np.zeros((3, 0)))
    for more in ({}, {"coulomb_friction__level": 1.0}, {"gravity_load__sine": 5.0}):
        row = row_of(plant, **more)
        there = row_of(plant, initial_angle=3.0, initial_speed=200.0, **more)
        answer = plant.simulate(row, whole)
        before = samples <= 0.05
        np.testing.assert_allclose(
            answer[before], plant.simulate(row, plain)[before], rtol=0.0, atol=1e-6
        )
        np.testing.assert_allclose(
            answer[~before], plant.simulate(there, alone)[1:], rtol=0.0, atol=1e-6
        )


def test_a_restart_keeps_the_motor_where_it_is_within_its_play(plant: Plant) -> None:
    """The surface is measured, the motor is half a gap ahead of it after a rise, as before."""
    row = row_of(plant, backlash__gap=2.0)
    samples = np.arange(0.0, 1.0, 0.002)
    command = 20.0 * samples
    plain = Stimulus(samples, command, True, samples, np.ones(1))
    answer = plant.simulate(row, plain)
    middle = samples.size // 2
    measured = np.array([[samples[middle]], [answer[middle]], [20.0]])
    again = plant.simulate(row, replace(plain, restarts=measured))
    np.testing.assert_allclose(again, answer, rtol=0.0, atol=1e-5)
