"""The error against speed, angle and frequency, and the sentences that say what it shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from servosight.diagnose.trial import Judged
from servosight.diagnose.where import shares

Array = NDArray[np.float64]

_WORDS = {
    "reversal": "where the surface turns round",
    "standstill": "where the surface stands still",
    "slew": "while the surface is on its way",
    "step": "just after steps of the command",
    "high_frequency": "where the command swings fast",
}


@dataclass(frozen=True)
class Profile:
    """Rms and mean error in bins of some quantity; ``x`` (bins,) are the bins' centres."""

    x: Array
    rms_deg: Array
    mean_deg: Array
    count: NDArray[np.int_]


@dataclass(frozen=True)
class Spectrum:
    """Amplitude density of error and measured angle over frequency [deg/sqrt(Hz)]."""

    frequency_hz: Array
    error: Array
    angle: Array


def against_speed(judged: Sequence[Judged], bins: int = 15) -> Profile:
    """Error against the model's speed [deg/s]."""
    speeds = [np.gradient(one.predicted_deg, one.recording.time_s) for one in judged]
    return _profile(np.concatenate(speeds), _errors(judged), bins)


def against_angle(judged: Sequence[Judged], bins: int = 15) -> Profile:
    """Error against the model's angle [deg]."""
    return _profile(np.concatenate([one.predicted_deg for one in judged]), _errors(judged), bins)


def against_frequency(judged: Sequence[Judged]) -> Spectrum:
    """Spectral densities by Welch's method, of the longest recording, on an even grid of time."""
    one = max(judged, key=lambda item: item.recording.time_s.size)
    times = one.recording.time_s
    rate = 1.0 / float(np.median(np.diff(times)))
    grid = np.arange(times[0], times[-1], 1.0 / rate)
    length = min(512, grid.size)
    frequency, error = signal.welch(np.interp(grid, times, one.error_deg), rate, nperseg=length)
    _, angle = signal.welch(np.interp(grid, times, one.recording.angle_deg), rate, nperseg=length)
    return Spectrum(frequency, np.sqrt(error), np.sqrt(angle))


def sentences(judged: Sequence[Judged], floor_deg: float) -> list[str]:
    """Plain sentences on where the error is and what it depends on."""
    rms = float(np.sqrt(np.mean(_errors(judged) ** 2)))
    if rms <= 1.1 * floor_deg:
        return [f"The error ({rms:.3f} deg rms) is no larger than the noise: nothing stands out."]
    table = shares(judged)
    kind, share = next(iter(table.items()))
    said = [f"The error is largest {_WORDS[kind]} ({100 * share:.0f} % of its square)."]
    said.append(_speed_sentence(against_speed(judged)))
    said.append(_angle_sentence(against_angle(judged), rms))
    return said


def _speed_sentence(profile: Profile) -> str:
    speed = np.abs(profile.x)
    slow = profile.rms_deg[speed <= np.quantile(speed, 0.35)].mean()
    fast = profile.rms_deg[speed >= np.quantile(speed, 0.65)].mean()
    if fast > 1.6 * slow:
        return "It grows with speed."
    if slow > 1.6 * fast:
        return "It is larger at low speed than at high speed."
    return "It does not grow with speed."


def _angle_sentence(profile: Profile, rms: float) -> str:
    bend = float(np.ptp(profile.mean_deg)) if profile.mean_deg.size else 0.0
    if bend > 1.5 * rms:
        return "Its mean changes with the angle, as a load that depends on position would cause."
    return "Its mean hardly depends on the angle."


def _errors(judged: Sequence[Judged]) -> Array:
    return np.concatenate([one.error_deg for one in judged])


def _profile(x: Array, error: Array, bins: int) -> Profile:
    edges = np.unique(np.quantile(x, np.linspace(0.0, 1.0, bins + 1)))
    if edges.size < 2:
        edges = np.array([x.min() - 0.5, x.max() + 0.5])
    index = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, edges.size - 2)
    count = np.bincount(index, minlength=edges.size - 1)
    filled = np.maximum(count, 1)
    mean = np.bincount(index, error, edges.size - 1) / filled
    square = np.bincount(index, error**2, edges.size - 1) / filled
    return Profile(0.5 * (edges[1:] + edges[:-1]), np.sqrt(square), mean, count)
