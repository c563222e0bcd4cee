"""Faults of a log's bus: what is left out, and that nothing a servo made is."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from servosight.diagnose import PriorKnowledge, compare, diagnose
from servosight.identify.fit import identify
from servosight.identify.problem import ReadErrorLimits, usable_views
from servosight.identify.problem.samples._old_values import held_values, old_values
from servosight.identify.problem.samples._read_errors import judged_reads
from servosight.models.core import Array, Mask, Recording
from servosight.models.effects import catalogue

STEP_DEG = 360.0 / 4096


def wrong_reads(recording: Recording, *limits: ReadErrorLimits) -> Mask:
    return judged_reads(recording, *limits).wrong


def log(angle_deg: Array | None = None, rate_hz: float = 100.0) -> Recording:
    """Six seconds of an encoder on a servo that follows a sum of two sines."""
    time_s = np.arange(0.0, 6.0, 1.0 / rate_hz)
    moved = 20.0 * np.sin(2.0 * time_s - 0.2) + 5.0 * np.sin(9.0 * time_s - 0.6)
    command = 20.0 * np.sin(2.0 * time_s) + 5.0 * np.sin(9.0 * time_s)
    noisy = moved + np.random.default_rng(3).normal(0.0, 0.03, time_s.size)
    angle = STEP_DEG * np.round(noisy / STEP_DEG) if angle_deg is None else angle_deg
    return Recording("log", time_s, command, time_s, angle)


def glitched(recording: Recording, at: dict[int, float]) -> Recording:
    angle = recording.angle_deg.copy()
    for index, size in at.items():
        angle[index] += size
    return replace(recording, angle_deg=angle)


def test_wrong_reads_are_found_and_told() -> None:
    wrong = glitched(log(), {2: 90.0, 131: 11.25, 304: -45.0, 305: -44.0, 500: 180.0})
    (found,), notes = usable_views([wrong])
    assert np.flatnonzero(wrong_reads(wrong)).tolist() == [2, 131, 304, 305, 500]
    np.testing.assert_array_equal(found.time_s, np.delete(wrong.time_s, [2, 131, 304, 305, 500]))
    assert found.command_deg is wrong.command_deg
    (note,) = notes
    assert note.startswith("log: 5 of 600 samples are read errors")
    assert note.endswith("were left out, the first at 0.02 s")


def test_sigma_and_shared_errors_lose_the_same_samples() -> None:
    sound = log()
    sigma, shared = np.arange(600.0) + 1.0, np.arange(1200.0).reshape(600, 2)
    wrong = replace(glitched(sound, {131: 30.0}), sigma_deg=sigma, shared_deg=shared)
    (found,), _ = usable_views([wrong])
    assert found.sigma_deg is not None
    assert found.shared_deg is not None
    np.testing.assert_array_equal(found.sigma_deg, np.delete(sigma, 131))
    np.testing.assert_array_equal(found.shared_deg, np.delete(shared, 131, axis=0))


@pytest.mark.parametrize(
    ("change", "size"),
    [
        ({"acceleration": 1e3}, 30.0),
        ({"local": 1e4}, 30.0),
        ({"steps": 400.0}, 30.0),
        ({"range_share": 1.0}, 30.0),
        ({"return_share": 1e-3}, 30.0),
        ({"command_share": 1e-9, "response_s": 6.0}, 30.0),
        ({"most": 1e-3}, 30.0),
        ({"longest": 0}, 30.0),
        ({"around": 200}, 30.0),
    ],
)
def test_each_limit_of_wrong_reads_counts(change: dict[str, Any], size: float) -> None:
    wrong = glitched(log(), {131: size})
    if "command_share" in change:  # the command goes out and back as well
        command = wrong.command_deg.copy()
        command[120] += 20.0
        wrong = replace(wrong, command_deg=command)
    assert not np.any(wrong_reads(wrong, ReadErrorLimits(**change)))


def test_what_a_short_command_did_stays() -> None:
    """A pulse of one sample moves the surface out and back; the next second it is no answer."""
    wrong = glitched(log(), {131: 30.0})
    command = wrong.command_deg.copy()
    command[125] += 40.0
    assert not np.any(wrong_reads(replace(wrong, command_deg=command)))
    command = wrong.command_deg.copy()
    command[25] += 40.0
    assert np.any(wrong_reads(replace(wrong, command_deg=command)))


def test_many_wrong_reads_are_told_and_stay() -> None:
    """One sample in five: whatever this is, it is a property of the recording."""
    many = glitched(log(), dict.fromkeys(range(15, 580, 5), 30.0))
    (found,), (note,) = usable_views([many])
    assert found is many
    assert note.startswith("log: 113 of 600 samples jump away and back like read errors")
    assert "over 15 % of all" in note


@pytest.mark.parametrize(
    "at",
    [
        {310: 40.0, 311: -60.0},
        {310: 40.0, 312: -60.0},
        {310: 40.0, 312: 40.0},
        {310: 40.0, 311: 40.0, 312: 40.0, 313: 40.0},
        {0: 40.0},
        {0: 40.0, 1: -50.0, 598: 40.0, 599: 40.0},
        {1: 40.0},
        {599: -40.0},
    ],
)
def test_wrong_reads_side_by_side_and_at_the_ends_are_found(at: dict[int, float]) -> None:
    """Together with single ones, which they used to hide."""
    single = {100: 40.0, 200: 40.0, 450: 40.0}
    wrong = wrong_reads(glitched(log(), at | single))
    assert np.flatnonzero(wrong).tolist() == sorted([*at, *single])


def test_a_recording_that_begins_with_a_step_keeps_its_first_sample() -> None:
    """The servo leaves where it was within a sample, and the command says why."""
    time_s = np.arange(0.0, 6.0, 0.05)
    angle = np.where(time_s > 0.0, 20.0, 0.0) + np.random.default_rng(0).normal(0.0, 0.03, 120)
    command = np.where(time_s > 0.0, 20.0, 0.0)
    assert not np.any(wrong_reads(Recording("step", time_s, command, time_s, angle)))


@pytest.mark.parametrize("rate_hz", [20.0, 50.0])
def test_a_servo_that_jumps_between_samples_loses_nothing(rate_hz: float) -> None:
    """10 deg within a sample, with an overshoot of one sample, as its command does it."""
    time_s = np.arange(0.0, 12.0, 1.0 / rate_hz)
    command = 10.0 * np.round(np.sin(2.1 * time_s) + np.sin(1.3 * time_s))
    jumps = np.diff(command, prepend=command[0])
    angle = command + 0.5 * jumps + np.random.default_rng(0).normal(0.0, 0.03, time_s.size)
    jumping = Recording("jumps", time_s, command, time_s, angle)
    assert usable_views([jumping]) == ([jumping], [])


def injected(
    angle_deg: Array, kind: str, share: float, rng: np.random.Generator
) -> tuple[Array, Mask]:
    """The angle with about ``share`` of its samples read wrongly, and which."""
    found, wrong = angle_deg.copy(), rng.random(angle_deg.size) < share
    if kind == "zeros":
        found[wrong] = 0.0
    elif kind == "uniform":
        found[wrong] = rng.uniform(-180.0, 180.0, int(wrong.sum()))
    else:
        wrong &= np.arange(angle_deg.size) % 12 == 6
        size = {"single": 1, "pair": 2, "burst": 4}[kind]
        for first in np.flatnonzero(wrong):
            run = slice(first, first + size)
            wrong[run] = True
            found[run] += 40.0 * rng.choice((-1.0, 1.0), 1 if kind == "burst" else size)
    return found, wrong


@pytest.mark.parametrize("kind", ["single", "pair", "burst", "zeros", "uniform"])
@pytest.mark.parametrize("effect", ["linear", "backlash", "coulomb_friction", "rate_limit"])
def test_nearly_all_injected_errors_are_found(record: Any, kind: str, effect: str) -> None:
    """95 % of those above 6 deg, 85 % in bursts, at 120 Hz; of 1,000 good samples two are lost."""
    true = {f"{effect}__{name}": value for name, value in TRUE.get(effect, {}).items()}
    sound = record(20.0, 1, T=0.03, **true)
    large, hit, lost = 0, 0, 0
    for share in (0.001, 0.01, 0.03, 0.1):
        angle, wrong = injected(sound.angle_deg, kind, share, np.random.default_rng(7))
        found = wrong_reads(replace(sound, angle_deg=angle, sigma_deg=None))
        matters = wrong & (np.abs(angle - sound.angle_deg) > 6.0)
        large, hit = large + int(matters.sum()), hit + int(np.sum(matters & found))
        lost += int(np.sum(found & ~wrong))
    assert hit >= (0.85 if kind == "burst" else 0.95) * large, (hit, large)
    assert lost <= 0.002 * 4 * sound.time_s.size


def test_old_values_are_found_and_told() -> None:
    sound = log(rate_hz=50.0)
    angle = sound.angle_deg.copy()
    for index in (90, 91, 144):
        angle[index] = angle[index - 1]
    (found,), notes = usable_views([replace(sound, angle_deg=angle)])
    assert found.time_s.size == 297
    assert notes == [
        "log: 3 of 300 samples are old values, read again while the servo moves, and were left "
        "out, the first at 1.8 s"
    ]


@pytest.mark.parametrize(
    "change", [{"moving_steps": 50.0}, {"longest": 0}, {"made_up": 1.0001}, {"alike": 1.0}]
)
def test_each_limit_of_old_values_counts(change: dict[str, Any]) -> None:
    sound = log(rate_hz=50.0)  # fastest at this sample: the speeds beside it rise and fall
    angle = sound.angle_deg.copy()
    angle[263] = angle[262]
    wrong = replace(sound, angle_deg=angle)
    assert np.flatnonzero(old_values(wrong)).tolist() == [263]
    assert not np.any(old_values(wrong, ReadErrorLimits(**change)))


def braking() -> Recording:
    """Steps of 60 deg at 100 Hz: each move ends with speeds that halve from sample to sample."""
    time_s = np.arange(0.0, 6.0, 0.01)
    step, since = np.divmod(time_s + 1e-9, 1.0)
    target = 60.0 * (step % 2)
    gone = np.exp(-since / 0.02) * (1.0 + since / 0.02)
    angle = np.round(target + (60.0 - 2.0 * target) * gone, 2)
    return replace(log(), time_s=time_s, angle_deg=angle, command_time_s=time_s, command_deg=target)


def test_an_old_value_is_found_where_the_servo_brakes() -> None:
    """Speeds beside it differ by a factor of five, and fall in order across it."""
    sound = braking()
    assert not np.any(old_values(sound))
    angle = sound.angle_deg.copy()
    angle[105] = angle[104]
    assert np.flatnonzero(old_values(replace(sound, angle_deg=angle))).tolist() == [105]


def test_a_servo_that_brakes_and_sticks_loses_nothing() -> None:
    """It rests for a sample and goes on from there, more slowly than it came."""
    sound = braking()
    stuck = sound.angle_deg.copy()
    stuck[105:] = sound.angle_deg[104:-1]
    assert not np.any(old_values(replace(sound, angle_deg=stuck)))


def held_log(every: float) -> Recording:
    """A sensor that updates at ``every`` samples of the log, on average."""
    sound = log(rate_hz=100.0)
    latest = np.floor(np.floor(np.arange(600) / every) * every + 1e-9).astype(int)
    return replace(sound, angle_deg=sound.angle_deg[latest])


@pytest.mark.parametrize("every", [2.0, 1.6, 3.0])
def test_a_sensor_slower_than_the_log_is_found(every: float) -> None:
    """Of each value in motion the first sample stays; at rest and at reversals all do."""
    slow = held_log(every)
    held = held_values(slow)
    assert held.sum() > 0.3 * (1.0 - 1.0 / every) * 600
    assert np.all(np.diff(slow.angle_deg)[np.flatnonzero(held) - 1] == 0.0)
    (found,), notes = usable_views([slow])
    assert found.time_s.size < 600 - 0.9 * held.sum()
    assert "old values" in notes[0]


@pytest.mark.parametrize(
    "change",
    [
        {"held_runs": 700},
        {"held_alike": 1.01},
        {"held_share": 1.01},
        {"held_speeds": 50.0},
        {"longest": 1},
        {"moving_steps": 100.0},
    ],
)
def test_each_limit_of_held_values_counts(change: dict[str, Any]) -> None:
    assert np.any(held_values(held_log(2.0)))
    assert not np.any(held_values(held_log(2.0), ReadErrorLimits(**change)))


def test_a_servo_that_sticks_and_slips_is_no_slow_sensor() -> None:
    """It leaps a degree at a time, ever faster: the rests become shorter, one sample in the end."""
    time_s = np.arange(0.0, 6.0, 0.01)
    for last_deg_s in (30.0, 60.0, 100.0):
        way = 0.5 * last_deg_s / 6.0 * time_s**2
        slipping = replace(log(), angle_deg=np.floor(way), command_deg=way)
        assert not np.any(held_values(slipping))
        assert not np.any(held_values(replace(slipping, angle_deg=np.floor(0.5 * way) * 2.0)))


def test_a_servo_that_follows_a_staircase_is_no_slow_sensor() -> None:
    """Its command rests as often as its angle does."""
    slow = held_log(2.0)
    command = np.repeat(slow.command_deg[::2], 2)
    assert not np.any(held_values(replace(slow, command_deg=command)))


def test_a_servo_that_sticks_loses_nothing() -> None:
    """It stands still for a sample and goes on from there: the way is not made up for."""
    angle = np.concatenate([np.arange(30), [29], np.arange(30, 60), [59] * 3, np.arange(60, 90)])
    sticking = np.resize(np.concatenate([angle, angle[::-1]]) * 0.5, 600)
    assert not np.any(old_values(log(sticking)))
    assert not np.any(wrong_reads(log(sticking)))


def test_a_long_recording_takes_a_time_in_proportion() -> None:
    """A million samples of an encoder, half of them at rest: none is lost."""
    time_s = 1e-3 * np.arange(1_000_000)
    angle = STEP_DEG * np.round(20.0 * np.maximum(np.sin(time_s), 0.0) / STEP_DEG)
    whole = Recording("long", time_s, np.sin(time_s), time_s, angle)
    (found,), _ = usable_views([whole])
    assert found is whole


@pytest.mark.parametrize(
    ("key", "ratio", "words"),
    [
        ("loop_gain", "relative_gain", "different loop gains (100, 400)"),
        ("load_kg", "relative_load", "different loads in kg (100, 400)"),
        ("arm_m", "relative_load", "different arms in m (100, 400)"),
    ],
)
def test_set_ups_that_differ_are_told(key: str, ratio: str, words: str) -> None:
    one, other = (replace(log(), details={"setup": {key: value}}) for value in (100.0, 400.0))
    (note,) = usable_views([one, other])[1]
    assert words in note
    assert f"give {ratio}" in note
    assert usable_views([one, replace(other, **{ratio: 4.0})])[1] == []  # type: ignore[arg-type]
    assert usable_views([one, one, log()])[1] == []


EFFECTS = [
    *("backlash", "coulomb_friction", "stribeck_friction", "dead_zone", "cogging", "rate_limit"),
    *("flexible_shaft", "gravity_load"),
]
TRUE = {
    "backlash": {"gap": 1.0},
    "coulomb_friction": {"level": 1.5},
    "stribeck_friction": {"level": 1.0, "excess": 1.5, "speed": 20.0},
    "dead_zone": {"half_width": 0.7},
    "cogging": {"amplitude": 1.0, "period": 9.0, "phase": 0.4},
    "rate_limit": {"rate": 120.0},
    "flexible_shaft": {"frequency": 9.0, "damping": 0.05, "inertia_ratio": 0.3},
    "gravity_load": {"sine": 3.0, "cosine": 1.0},
}


@pytest.mark.parametrize("effect", EFFECTS)
def test_clean_recordings_lose_nothing(record: Any, effect: str) -> None:
    """Each at four rates and three resolutions, with three noises: 288 recordings in all."""
    true = {f"{effect}__{name}": value for name, value in TRUE[effect].items()}
    for seed in range(3):
        whole = record(6.0, seed, **true)
        for every in (1, 2, 4, 6):
            for step_deg in (0.0, STEP_DEG, 0.5):
                angle = whole.angle_deg[::every]
                if step_deg:
                    angle = step_deg * np.round(angle / step_deg)
                one = replace(whole, time_s=whole.time_s[::every], angle_deg=angle, sigma_deg=None)
                (found,), notes = usable_views([one])
                assert found is one, (seed, every, step_deg, notes)


def test_a_glitched_log_gives_what_its_clean_twin_does(record: Any) -> None:
    """k, T, xi within a tenth of a sigma of the clean recording's; warnings say what was done."""
    sound = record(5.0, 1)
    wrong = glitched(sound, {150: 45.0, 333: -22.5, 500: 180.0})
    clean = identify([sound], catalogue=catalogue(), method="gradient")
    found = identify([wrong], catalogue=catalogue(), method="gradient")
    assert any("3 of 600 samples are read errors" in text for text in found.warnings)
    assert found.samples == clean.samples - 3
    assert found.rmse_deg == pytest.approx(clean.rmse_deg, rel=0.01)
    for name in ("k", "T", "xi"):
        one, other = clean.parameters[name], found.parameters[name]
        assert not isinstance(one, tuple)
        assert not isinstance(other, tuple)
        assert one.sigma is not None
        assert abs(one.value - other.value) < 0.1 * one.sigma
    compared = compare(clean.actuator, [wrong], catalogue=catalogue())
    assert compared.rmse_deg == pytest.approx(clean.rmse_deg, rel=0.01)
    assert any("read errors" in text for text in compared.warnings)


@pytest.mark.slow
def test_a_diagnosis_leaves_read_errors_out_as_well(record: Any) -> None:
    wrong = glitched(record(5.0, 1), {150: 45.0, 333: -22.5, 500: 180.0})
    others = [name for name in catalogue() if name != "backlash"]
    known = PriorKnowledge.of(catalogue(), without_effects=others)  # the linear model is judged
    why = diagnose([wrong], catalogue=catalogue(), auto=False, prior=known)
    assert why.verdict.value == "no_effect_missing"
    assert any("3 of 600 samples are read errors" in text for text in why.warnings)
