"""The noise of a recording, without any model of the servo.

Where the tracker gives a sigma, that is it. Otherwise: high-order divided differences remove what
is smooth and leave noise; they are taken where the command has been calmest, so that what the
servo does in a hurry does not count as noise. Never below the angle's own resolution / sqrt(12).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from servosight.models.recording import Recording

Array = NDArray[np.float64]

_ORDERS = (3, 4, 6)
_CALM_SHARE = 0.5
_MEMORY_S = 0.25
_MAD = 0.6744897501960817


def noise_deg(recording: Recording) -> float:
    """Standard deviation of the measured angle [deg]."""
    sigma = recording.sigma_deg
    if sigma is not None and np.all(sigma > 0.0):
        return float(np.sqrt(np.mean(sigma**2)))
    calm = np.argsort(_activity(recording), kind="stable")
    estimates = [_spread(recording, calm, order) for order in _ORDERS]
    return max(min(estimates), resolution_deg(recording.angle_deg) / math.sqrt(12.0))


def joint_noise_deg(recordings: tuple[Recording, ...]) -> float:
    """Rms noise over several recordings, weighted by their samples [deg]."""
    weights = [recording.time_s.size for recording in recordings]
    squares = [noise_deg(recording) ** 2 for recording in recordings]
    return float(np.sqrt(np.average(squares, weights=weights)))


def resolution_deg(angle_deg: Array) -> float:
    """Step of an encoder's grid; 0 where the angles lie on none."""
    levels = np.unique(angle_deg)
    if levels.size < 2:
        return 0.0
    gaps = np.diff(levels)
    gaps = gaps[gaps > 1e-9]
    if gaps.size == 0:
        return 0.0
    step = float(np.median(gaps[gaps < 1.5 * gaps.min()]))
    on_grid = np.abs(gaps / step - np.round(gaps / step)) < 0.05
    crowded = levels.size < 0.7 * angle_deg.size
    return step if crowded and np.mean(on_grid) > 0.95 else 0.0


def _spread(recording: Recording, calm: NDArray[np.intp], order: int) -> float:
    """Robust standard deviation of normalised divided differences where the command is calm."""
    differences = divided_differences(recording.time_s, recording.angle_deg, order)
    chosen = np.zeros(recording.time_s.size, dtype=bool)
    chosen[calm[: max(int(_CALM_SHARE * calm.size), 4 * order)]] = True
    # A difference counts where all its samples are calm.
    window = np.convolve(chosen, np.ones(order + 1), mode="valid") > order + 0.5
    picked = differences[window] if window.sum() >= 20 else differences
    spread = float(np.median(np.abs(picked)) / _MAD)
    for _ in range(3):
        inside = np.abs(picked) <= 3.0 * spread
        if spread == 0.0 or not inside.any():
            break
        spread = float(np.sqrt(np.mean(picked[inside] ** 2)) / 0.98658)
    return spread


def divided_differences(time_s: Array, values: Array, order: int) -> Array:
    """Divided differences over ``order + 1`` neighbours, scaled to unit noise gain.

    For any spacing of the samples: the weights 1 / prod(t_i - t_j) annihilate polynomials below
    ``order`` (de Boor, A Practical Guide to Splines, chapter 1). Shape (samples - order,).
    """
    windows = np.lib.stride_tricks.sliding_window_view(time_s, order + 1)
    spacing = windows[:, :, None] - windows[:, None, :]
    scale = np.median(np.diff(time_s))
    spacing = spacing / scale + np.eye(order + 1)
    weights = 1.0 / np.prod(spacing, axis=2)
    weights /= np.sqrt(np.sum(weights**2, axis=1, keepdims=True))
    data = np.lib.stride_tricks.sliding_window_view(values, order + 1)
    return np.asarray(np.einsum("ij,ij->i", weights, data))


def _activity(recording: Recording) -> Array:
    """How much the command has moved just before each sample [deg], with a long memory."""
    travel = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(recording.command_deg)))])
    times = recording.command_time_s

    def travelled(t: Array) -> Array:
        return np.asarray(np.interp(t, times, travel))

    now = recording.time_s
    return travelled(now + 0.02) - travelled(now - _MEMORY_S)
