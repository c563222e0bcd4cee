"""Lamps that flicker at twice the mains frequency: the shift of an exposure's mean time of light.

A picture collects most of its light while the lamp is bright, so a moving surface appears where it
was then. The lamp's brightness is estimated from the pictures' gain, frame by frame. Sampled once
a frame it is aliased, but there are only two mains frequencies to choose from.
"""

from __future__ import annotations

import numpy as np

from servosight.models.core import Array

_MAINS_HZ = (100.0, 120.0)
_WINDOW_S = 0.5  # on either side: the time for which mains and camera clock stay in phase
_LEAST_FRAMES = 24
_LEAST_SHARE = 0.005  # of the brightness: less is negligible
_SURE = 5.0
_APART = 0.2  # least power of an aliased wave after a straight line is removed


def light_centre(time_s: Array, gain: Array, exposure_s: float) -> tuple[Array, Array]:
    """Delay of the mean time of light after mid-exposure, and its sigma [s]; (frames,) each.

    ``gain`` is the light's, NaN where not known. All 0 where no flicker shows.
    """
    late, doubt = np.zeros((2, time_s.size))
    if exposure_s <= 0.0:
        return late, doubt
    found = [_wave(time_s, gain, hertz) for hertz in _MAINS_HZ]
    certainty = [
        float(np.median((np.abs(wave) / sigma)[np.isfinite(sigma)]))
        if np.isfinite(sigma).any()
        else 0.0
        for wave, _, sigma in found
    ]
    best = int(np.argmax(certainty))
    wave, steady, sigma = found[best]
    if certainty[best] < _SURE or float(np.nanmedian(np.abs(wave) / steady)) < _LEAST_SHARE:
        return late, doubt
    omega = 2.0 * np.pi * _MAINS_HZ[best]
    half = 0.5 * omega * exposure_s
    # The mean over an exposure shows the wave weakened by sin(half) / half; its first moment is
    # that of sin(omega t) t.
    moment = 0.5 * exposure_s * (np.sin(half) / half - np.cos(half)) / max(np.sin(half), 1e-3)
    light = np.where(np.isfinite(gain), gain, steady)
    return np.nan_to_num(moment * wave.real / light), np.nan_to_num(moment * sigma / light)


def _wave(time_s: Array, gain: Array, hertz: float) -> tuple[Array, Array, Array]:
    """Complex amplitude of the gain's wave about each frame, mean gain, and the wave's sigma.

    The real part is the wave's share that rises through zero at mid-exposure. NaN where too little
    is known to tell.
    """
    wave = np.full(time_s.size, np.nan + 0j)
    steady, sigma = np.full((2, time_s.size), np.nan)
    known = np.isfinite(gain)
    for n, now in enumerate(time_s):
        near = known & (np.abs(time_s - now) < _WINDOW_S)
        if near.sum() < _LEAST_FRAMES:
            continue
        t = time_s[near] - now
        phase = 2.0 * np.pi * hertz * t
        slow = np.column_stack([np.ones_like(t), t, t * t])
        fast = np.column_stack([np.sin(phase), np.cos(phase)])
        apart = fast - slow @ np.linalg.lstsq(slow, fast, rcond=None)[0]
        if (apart**2).sum() < _APART * t.size:
            continue
        # The wave's amplitude may change with the lamp's brightness.
        terms = np.hstack([fast, slow, fast * t[:, None]])
        inverse = np.linalg.inv(terms.T @ terms)
        solution = inverse @ terms.T @ gain[near]
        left = gain[near] - terms @ solution
        wave[n] = solution[0] + 1j * solution[1]
        steady[n] = solution[2]
        sigma[n] = np.sqrt(inverse[0, 0] * (left @ left) / (t.size - terms.shape[1]))
    return wave, steady, sigma
