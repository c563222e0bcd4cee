"""A linear servo in a video: how far its parameters differ from those of the true angle."""

from __future__ import annotations

import numpy as np
from scipy import signal

from filmed.cases import STEP_S, Array, VideoCase
from servosight.identify.fit import identify
from servosight.models.core import Estimate, Recording
from servosight.models.effects import catalogue
from servosight.models.excitation import multisine
from servosight.sim.film import VideoSettings
from servosight.tracking.core import Track

TRUE = {"k": 0.92, "T": 0.02, "xi": 0.6}
_COMMAND_S = 0.01
_DURATION_S = 3.0
EXPOSURE_S = 0.002


def command() -> tuple[Array, Array]:
    """Times and values of a command, held between its rows."""
    time_s = np.arange(0.0, _DURATION_S, _COMMAND_S)
    return time_s, multisine(time_s, 18.0, 0.5, 6.0, seed=3)


def angle_deg(time_s: Array) -> Array:
    """The servo's answer, from rest; ``time_s`` on the trajectory's grid."""
    at_s, value = command()
    ticks = np.arange(round(float(time_s[-1]) / STEP_S) + 1)
    row = np.searchsorted(np.round(at_s / STEP_S), ticks, side="right") - 1
    k, T, xi = TRUE["k"], TRUE["T"], TRUE["xi"]
    system = signal.TransferFunction([k], [T**2, 2.0 * xi * T, 1.0])
    _, answer, _ = signal.lsim(system, value[row], ticks * STEP_S, interp=False)
    return np.asarray(answer[np.round(time_s / STEP_S).astype(int)])


def case(seed: int) -> VideoCase:
    """The servo on film; the seed draws the camera's noise and the print."""
    settings = VideoSettings(texture_seed=seed)
    name = f"linear servo, multisine, {seed}"
    return VideoCase(name, angle_deg, settings=settings, duration_s=_DURATION_S, seed=seed)


def apart(track: Track, true_deg: Array) -> dict[str, float]:
    """Each parameter through the video less that from the true angle, over sigma: that of the
    frames' own noise and of what they share."""
    at_s, value = command()

    def fitted(angle_deg: Array, shared_deg: Array | None) -> dict[str, Estimate]:
        recording = Recording(
            "filmed", at_s, value, track.time_s, angle_deg, track.sigma_deg,
            exposure_s=EXPOSURE_S, shared_deg=shared_deg,
        )  # fmt: skip
        return dict(identify([recording], (), catalogue=catalogue()).actuator.parameters)

    seen, true = fitted(track.angle_deg, track.shared_deg), fitted(true_deg, None)
    return {
        name: (seen[name].value - true[name].value) / float(seen[name].sigma or np.nan)
        for name in TRUE
    }
