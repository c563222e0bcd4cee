"""Limits of a scenario's values: what lies beyond is rejected before anything is computed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from servosight.models.core import check_fields, require
from servosight.models.effects import catalogue
from servosight.scenarios.camera_settings import check_camera, check_filming
from servosight.sim.bench import LONGEST_STEP_S, STEPS_PER_T
from servosight.sim.effects import TWIN_EFFECTS, resolve

if TYPE_CHECKING:
    from servosight.scenarios.scenario import Scenario

KINDS = ("standard", "steps", "chirp", "triangle", "sine", "multisine")
"""Commands that ``[motion]`` knows."""

MAX_STEPS = 10_000_000
"""Longest simulation, in steps of MuJoCo: some minutes, and 1 GB."""

MAX_FILM_PX = 2e11
"""Largest video, in pixels times frames: 640 x 480 at 240 Hz for 600 s is 4e10."""

MAX_SINES = 1e7
"""Rows of a multisine's command times its sines."""

LARGEST_DEG = 180.0
_MAX_UNCATALOGUED = 1e4


def check_scenario(scenario: Scenario, source: str) -> None:
    """Raise InputError, which names ``source`` and the key, for a value that makes no sense."""
    servo, motion = scenario.servo, scenario.motion
    require(motion.kind in KINDS, source, "motion.kind", motion.kind, f"one of {', '.join(KINDS)}")
    check_fields(scenario, source)
    require(servo.k != 0.0, source, "servo.k", servo.k, "a gain that is not 0")
    require(
        motion.low_hz < motion.high_hz, source, "motion.low_hz", motion.low_hz, "less than high_hz"
    )
    _check_angles(scenario, source)
    _check_size_of_command(scenario, source)
    check_camera(scenario.camera, source)
    check_filming(scenario.filming, scenario.camera, source)
    _check_effects(scenario, source)
    _check_work(scenario, source)


def _check_angles(scenario: Scenario, source: str) -> None:
    reach = abs(scenario.servo.k * scenario.motion.amplitude_deg)
    require(
        reach <= LARGEST_DEG,
        source,
        "servo.k",
        scenario.servo.k,
        f"an angle of at most {LARGEST_DEG:g} deg at motion.amplitude_deg = "
        f"{scenario.motion.amplitude_deg:g}",
    )


def _check_size_of_command(scenario: Scenario, source: str) -> None:
    motion = scenario.motion
    if motion.kind != "multisine":
        return
    sines = 0.5 * motion.high_hz / motion.low_hz
    require(
        sines * scenario.duration_s * motion.rate_hz <= MAX_SINES,
        source,
        "motion.low_hz",
        motion.low_hz,
        f"fewer sines than the {sines:.3g} that go from low_hz to high_hz = {motion.high_hz:g}",
    )


def _check_effects(scenario: Scenario, source: str) -> None:
    known = catalogue()
    for effect, values in resolve(scenario.effects).items():
        for name, value in values.items():
            holds = 0.0 < value <= _MAX_UNCATALOGUED
            expected = f"more than 0 and at most {_MAX_UNCATALOGUED:g}"
            if effect in known:
                bounds = known[effect].parameter(name)
                holds = bounds.low <= value <= bounds.high
                expected = f"{bounds.low:g} to {bounds.high:g} {bounds.unit}"
            require(holds, source, f"{effect}.{name}", value, expected)


def _check_work(scenario: Scenario, source: str) -> None:
    """Reject what would take hours, or more memory than a computer has."""
    finest = max([STEPS_PER_T, *(TWIN_EFFECTS[name].steps_per_T for name in scenario.effects)])
    steps = scenario.duration_s / min(LONGEST_STEP_S, scenario.servo.T / finest)
    require(
        steps <= MAX_STEPS,
        source,
        "duration_s",
        scenario.duration_s,
        f"at most {scenario.duration_s * MAX_STEPS / steps:.3g} seconds for a servo with T = "
        f"{scenario.servo.T:g} s and these effects",
    )
    camera = scenario.camera
    if scenario.video:
        frame_px = camera.width * camera.height
        require(
            scenario.duration_s * camera.rate_hz * frame_px <= MAX_FILM_PX,
            source,
            "duration_s",
            scenario.duration_s,
            f"at most {MAX_FILM_PX / (camera.rate_hz * frame_px):.3g} seconds for a video of "
            f"{camera.width} x {camera.height} pixels at {camera.rate_hz:g} Hz",
        )
