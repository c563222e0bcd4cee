"""A polled bus: goals go out, positions come back late, and the host stamps both by its own clock.

At each poll the host writes the goal and reads the position. The goal reaches the servo ``write_s``
after it was sent; the position that arrives was measured ``read_s`` before. Both stand in the log
at the poll's stamp, so that the log has their sum as dead time.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array, Mask, Recording

from .draw import CompoundSetup
from .goals import command
from .servo import ENCODER_DEG, GRID_S, KEPT, STEP_S, march

SETTLE_TIMES = 12.0
"""The servo comes to rest at its first goal before the log begins, for so many time constants."""


@dataclass(frozen=True)
class Log:
    """A recording; ``ideal``, the same without noise on true times; and which samples are sound.

    ``true_deg`` (samples,) is where the servo was at the recording's own times.
    """

    recording: Recording
    ideal: Recording
    true_deg: Array
    sound: Mask

    @property
    def noise_deg(self) -> float:
        """Rms of what is not motion: encoder, noise, jitter of the stamps."""
        errors = (self.recording.angle_deg - self.true_deg)[self.sound]
        return float(np.sqrt(np.mean(errors**2)))


def logged(
    setup: CompoundSetup, run: str, part: str, gain: float, duration_s: float, *, faults: bool
) -> Log:
    """One recording of a run; ``faults`` adds repeated samples and read errors."""
    bus = setup.bus
    time_s, goal = command(setup, run, part, gain, duration_s)
    steps = KEPT * int(np.ceil(duration_s / GRID_S))
    settle = int(SETTLE_TIMES * np.sqrt(setup.servo.inertia) / STEP_S)
    angle = march(setup.servo, gain, time_s + bus.write_s, goal, settle, steps)
    grid_s = GRID_S * np.arange(angle.size)
    true = np.interp(time_s - bus.read_s, grid_s, angle)
    rng = setup.rng(run, part, gain, "log")
    noisy = true + rng.normal(0.0, bus.noise_deg, true.size)
    seen = ENCODER_DEG * np.round(noisy / ENCODER_DEG)
    stamps = time_s + rng.normal(0.0, bus.stamp_jitter_s, time_s.size)
    stamps = np.maximum.accumulate(stamps)
    stamps += 1e-6 * np.arange(stamps.size)  # two equal stamps would be refused
    # The stamp is late or early, the angle is not: what the servo did at the stamp is the truth.
    at_stamp = np.interp(stamps - bus.read_s, grid_s, angle)
    sound = np.ones(true.size, dtype=bool)
    if faults:
        seen, sound = _faulty(seen, setup, rng)
    name = f"{run}-{part}-{gain:g}"
    recording = Recording(name, stamps, goal, stamps, seen, relative_gain=gain)
    ideal = Recording(name, time_s, goal, time_s, true, relative_gain=gain)
    return Log(recording, ideal, at_stamp, sound)


def _faulty(angle: Array, setup: CompoundSetup, rng: np.random.Generator) -> tuple[Array, Mask]:
    """Samples that repeat the one before, and single reads that are wrong by bits of the word."""
    found = angle.copy()
    repeated = rng.random(angle.size) < setup.bus.repeated
    repeated[0] = False
    for n in np.flatnonzero(repeated):
        found[n] = found[n - 1]
    glitched = rng.random(angle.size) < setup.bus.glitched
    bits = 2.0 ** rng.integers(7, 12, angle.size)
    found[glitched] += (ENCODER_DEG * bits * rng.choice((-1.0, 1.0), angle.size))[glitched]
    return found, ~(repeated | glitched)
