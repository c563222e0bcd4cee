"""Limits of a scenario's values: what lies beyond is rejected before anything is computed."""

from __future__ import annotations

from collections.abc import Mapping

from servosight.models.core import Camera, require
from servosight.models.effects import catalogue
from servosight.scenarios.settings import LARGEST_DEG, CommandSettings, LinearServo
from servosight.sim.assembled import longest_step_s
from servosight.sim.effects import TWIN_EFFECTS, resolve

MAX_STEPS = 10_000_000
"""Longest simulation, in steps of MuJoCo: some minutes, and 1 GB."""

MAX_FILM_PX = 2e11
"""Largest video, in pixels times frames: 640 x 480 at 240 Hz for 600 s is 4e10."""

MAX_SINES = 1e7
"""Rows of a multisine's command times its sines."""

_MAX_UNCATALOGUED = 1e4


def check_motion(
    servo: LinearServo, motion: CommandSettings, duration_s: float, source: str
) -> None:
    """Reject a servo that does not move or turns too far, and a command of no sense."""
    require(servo.k != 0.0, source, "servo.k", servo.k, "a gain that is not 0")
    require(
        motion.low_hz < motion.high_hz, source, "motion.low_hz", motion.low_hz, "less than high_hz"
    )
    require(
        abs(servo.k * motion.amplitude_deg) <= LARGEST_DEG,
        source,
        "servo.k",
        servo.k,
        f"an angle of at most {LARGEST_DEG:g} deg at motion.amplitude_deg = "
        f"{motion.amplitude_deg:g}",
    )
    if motion.kind == "multisine":
        _check_sines(motion, duration_s, source)


def _check_sines(motion: CommandSettings, duration_s: float, source: str) -> None:
    sines = 0.5 * motion.high_hz / motion.low_hz
    require(
        sines * duration_s * motion.rate_hz <= MAX_SINES,
        source,
        "motion.low_hz",
        motion.low_hz,
        f"fewer sines than the {sines:.3g} that go from low_hz to high_hz = {motion.high_hz:g}",
    )


def check_effects(effects: Mapping[str, Mapping[str, float]], source: str) -> None:
    """Reject unknown effects, and parameters out of bounds."""
    known = catalogue()
    for effect, values in resolve(effects).items():
        for name, value in values.items():
            holds = 0.0 < value <= _MAX_UNCATALOGUED
            expected = f"more than 0 and at most {_MAX_UNCATALOGUED:g}"
            if effect in known:
                bounds = known[effect].parameter(name)
                holds = bounds.low <= value <= bounds.high
                expected = bounds.range_words
            require(holds, source, f"{effect}.{name}", value, expected)


def check_work(
    servo: LinearServo, effects: Mapping[str, Mapping[str, float]], duration_s: float, source: str
) -> None:
    """Reject a simulation that would take hours, or more memory than a computer has."""
    steps = duration_s / longest_step_s(servo.T, (TWIN_EFFECTS[name] for name in effects))
    require(
        steps <= MAX_STEPS,
        source,
        "duration_s",
        duration_s,
        f"at most {duration_s * MAX_STEPS / steps:.3g} seconds for a servo with T = "
        f"{servo.T:g} s and these effects",
    )


def check_film(camera: Camera, duration_s: float, source: str) -> None:
    """Reject a video that would take hours."""
    frame_px = camera.width * camera.height
    require(
        duration_s * camera.rate_hz * frame_px <= MAX_FILM_PX,
        source,
        "duration_s",
        duration_s,
        f"at most {MAX_FILM_PX / (camera.rate_hz * frame_px):.3g} seconds for a video of "
        f"{camera.width} x {camera.height} pixels at {camera.rate_hz:g} Hz",
    )
