"""The camera's clock against the command's, from the brightness of a light with a known code.

A frame whose exposure contains a switching of the light is partly lit, and the part says where in
the exposure the light switched. So the offset between the clocks is known to a fraction of a frame,
and from its change over the recording the drift. Both come as mean and standard deviation of their
likelihood on a grid, not from its curvature: where no exposure contains a switching, the likelihood
is flat over the gap between two exposures, and the standard deviation is that of the gap.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from servosight.bench import light
from servosight.models.core import Array, InputError, lit_share

LARGEST_DRIFT = 3e-4
"""Quartz oscillators are within 1e-4 of their nominal frequency, two of them within 2e-4: no
larger drift is considered."""
SHORTEST_EXPOSURE_S = 1e-5

_OFFSETS, _DRIFTS, _EXPOSURES = 31, 15, 13
_ROUNDS = 8
_WIDE = 6.0  # standard deviations on each side of the grid
_PARTLY = (0.02, 0.98)  # share of light of a frame that contains a switching
_LEAST_PARTLY = 8
_LEAST_FRAMES = 30
_LEAST_CORRELATION = 0.7


@dataclass(frozen=True, kw_only=True)
class LightPattern:
    """When the light is on, by the command's clock: ``states`` (n,), 0 or 1, from ``time_s`` (n,).

    Before the first instant it is off.
    """

    time_s: Array
    states: Array

    @classmethod
    def of_command(cls, start_s: float, end_s: float, rate: float = 1.0) -> LightPattern:
        """The coded light from ``start_s`` to ``end_s`` by the host's clock.

        ``rate`` is how many of the host's seconds a second of the light's own clock lasts.
        """
        bits, bit_s = light.pattern(), rate * light.BIT_S
        count = math.ceil((end_s - start_s) / bit_s - 1e-9)
        edges_s = np.append(start_s + bit_s * np.arange(count), end_s)
        return cls(time_s=edges_s, states=np.append(np.resize(bits, count), False) * 1.0)

    @property
    def bit_s(self) -> float:
        """The time of one bit [s]."""
        return float(np.median(np.diff(self.time_s)))

    def share(self, mid_s: Array, exposure_s: float) -> Array:
        """The share of exposures about ``mid_s`` (any shape) in which it is on."""
        half = 0.5 * max(exposure_s, SHORTEST_EXPOSURE_S)
        return lit_share(self.time_s, self.states, mid_s - half, mid_s + half)


@dataclass(frozen=True, kw_only=True)
class ClockFit:
    """From a frame's stamp to the middle of its exposure on the command's clock.

    ``middle_s + offset_s + (1 + drift) (stamp_s - middle_s)``, with standard deviations; the offset
    is that in the middle of the recording, where it is independent of the drift. Whatever a stamp
    means, start of exposure or arrival of the frame, is part of the offset. ``exposure_s`` is the
    given one or the one found, ``correlation`` that of brightness and pattern.
    """

    middle_s: float
    offset_s: float
    offset_sigma_s: float
    drift: float
    drift_sigma: float
    exposure_s: float
    correlation: float
    frames: int

    def mid_exposure(self, stamps_s: Array) -> Array:
        """Times on the command's clock [s] of stamps (frames,)."""
        passed = stamps_s - self.middle_s
        return np.asarray(self.middle_s + self.offset_s + (1.0 + self.drift) * passed)

    def sigma_s(self, stamps_s: Array) -> Array:
        """Standard deviation of :meth:`mid_exposure` [s]."""
        passed = stamps_s - self.middle_s
        return np.asarray(np.hypot(self.offset_sigma_s, self.drift_sigma * passed))


def decode(
    stamps_s: Array,
    level: Array,
    pattern: LightPattern,
    *,
    exposure_s: float | None = None,
    guess_s: float = 0.0,
    reach_s: float = 1.0,
) -> ClockFit:
    """Offset and drift of a camera's clock from the light's brightness ``level`` (frames,).

    ``stamps_s`` (frames,) are the frames' times on the camera's clock; the offset is searched for
    within ``reach_s`` of ``guess_s``, which must be less than half of the pattern's period where it
    repeats. Without ``exposure_s`` the exposure is found as well. Raises InputError where the
    brightness does not follow the pattern.

    >>> pattern = LightPattern.of_command(0.0, 2.0)
    >>> mid_s = np.arange(-0.2, 2.2, 1 / 60)
    >>> level = 20.0 + 200.0 * pattern.share(mid_s, 0.004)
    >>> fit = decode(mid_s - 0.321, level, pattern, exposure_s=0.004)
    >>> bool(abs(fit.offset_s - 0.321) < 1e-3)
    True
    """
    if stamps_s.size < _LEAST_FRAMES:
        raise InputError(
            f"the coded light: {stamps_s.size} frames were taken while it ran; expected at least "
            f"{_LEAST_FRAMES}, record for longer"
        )
    middle_s = 0.5 * float(stamps_s[0] + stamps_s[-1])
    problem = _Problem(stamps_s, level, pattern, middle_s)
    start_s = exposure_s if exposure_s is not None else 0.3 * problem.frame_s
    step_s = min(0.25 * pattern.bit_s, problem.frame_s)
    coarse = guess_s + np.arange(-reach_s, reach_s + step_s, step_s)
    best_s = float(coarse[np.argmin(problem.misfit(coarse, np.zeros(1), start_s))])
    near_s = step_s + 1.2 * problem.frame_s  # no gap between two exposures is wider
    doubt_s = 0.0
    if exposure_s is None:
        best_s, _, drift, _ = problem.posterior(best_s, near_s, start_s)
        start_s, best_s, doubt_s = problem.with_exposure(best_s, drift)
    offset_s, offset_sigma_s, drift, drift_sigma = problem.posterior(best_s, near_s, start_s)
    offset_sigma_s = max(offset_sigma_s, doubt_s)
    correlation = problem.correlation(offset_s, drift, start_s)
    if correlation < _LEAST_CORRELATION:
        raise InputError(
            f"the coded light: the brightness follows its pattern with a correlation of "
            f"{correlation:.2f}; expected more than {_LEAST_CORRELATION:g}, so bring the light "
            f"fully into the picture and let it fill some 10 x 10 pixels"
        )
    return ClockFit(
        middle_s=middle_s,
        offset_s=offset_s,
        offset_sigma_s=offset_sigma_s,
        drift=drift,
        drift_sigma=drift_sigma,
        exposure_s=start_s,
        correlation=correlation,
        frames=stamps_s.size,
    )


class _Problem:
    """Squared residuals of a line through brightness over the share of light."""

    def __init__(
        self, stamps_s: Array, level: Array, pattern: LightPattern, middle_s: float
    ) -> None:
        self.stamps_s, self.pattern, self.middle_s = stamps_s, pattern, middle_s
        self.away = level - level.mean()
        self.total = float(self.away @ self.away)
        self.frame_s = float(np.median(np.diff(stamps_s)))
        self.half_s = 0.5 * float(stamps_s[-1] - stamps_s[0])

    def share(self, offset_s: float, drifts: Array, exposure_s: float) -> Array:
        """The share of light (drifts, frames)."""
        passed = self.stamps_s - self.middle_s
        mid_s = self.stamps_s + offset_s + drifts[:, None] * passed
        return self.pattern.share(mid_s, exposure_s)

    def misfit(self, offsets_s: Array, drifts: Array, exposure_s: float) -> Array:
        """Squared residual (offsets, drifts); dark and bright level are fitted."""
        table = np.empty((offsets_s.size, drifts.size))
        for row, offset_s in enumerate(offsets_s):
            share = self.share(float(offset_s), drifts, exposure_s)
            share = share - share.mean(1, keepdims=True)
            along = share @ self.away
            power = np.einsum("df,df->d", share, share)
            # A light that comes out of it darker when it is on is none.
            table[row] = self.total - np.maximum(along, 0.0) ** 2 / np.maximum(power, 1e-9)
        return table

    def correlation(self, offset_s: float, drift: float, exposure_s: float) -> float:
        """Of brightness and pattern, 0 to 1."""
        if self.total <= 0.0:
            return 0.0
        misfit = self.misfit(np.array([offset_s]), np.array([drift]), exposure_s)[0, 0]
        return float(np.sqrt(max(1.0 - misfit / self.total, 0.0)))

    def posterior(
        self, offset_s: float, reach_s: float, exposure_s: float
    ) -> tuple[float, float, float, float]:
        """Mean and standard deviation of offset [s] and drift, on a grid that closes in on them."""
        reach, bend = reach_s, min(LARGEST_DRIFT, 3.0 * reach_s / self.half_s)
        drift, sigma_s, sigma = 0.0, reach, bend
        for _ in range(_ROUNDS):
            offsets = offset_s + np.linspace(-reach, reach, _OFFSETS)
            low, high = max(drift - bend, -LARGEST_DRIFT), min(drift + bend, LARGEST_DRIFT)
            drifts = np.linspace(low, high, _DRIFTS)
            table = self.misfit(offsets, drifts, exposure_s)
            row, column = np.unravel_index(np.argmin(table), table.shape)
            noise = self._noise(float(offsets[row]), float(drifts[column]), exposure_s)
            weight = np.exp(-0.5 * (table - table.min()) / noise)
            offset_s, sigma_s = _moments(offsets, weight.sum(1))
            drift, sigma = _moments(drifts, weight.sum(0))
            narrow = _WIDE * sigma_s, _WIDE * sigma
            if narrow[0] > 0.7 * reach and narrow[1] > 0.7 * bend:
                break
            reach = max(narrow[0], 4.0 * reach / _OFFSETS)
            bend = max(narrow[1], 4.0 * bend / _DRIFTS)
        return offset_s, sigma_s, drift, sigma

    def with_exposure(self, offset_s: float, drift: float) -> tuple[float, float, float]:
        """Exposure, offset and the offset's standard deviation where both are unknown [s]."""
        exposure_s, reach = 0.5 * self.frame_s, 0.5 * self.frame_s
        low, high = SHORTEST_EXPOSURE_S, 1.05 * self.frame_s
        for _ in range(_ROUNDS):
            exposures = np.linspace(low, high, _EXPOSURES)
            offsets = offset_s + np.linspace(-reach, reach, _OFFSETS)
            drifts = np.array([drift])
            table = np.stack([self.misfit(offsets, drifts, float(e))[:, 0] for e in exposures])
            row, column = np.unravel_index(np.argmin(table), table.shape)
            noise = self._noise(float(offsets[column]), drift, float(exposures[row]))
            weight = np.exp(-0.5 * (table - table.min()) / noise)
            exposure_s, exposure_sigma = _moments(exposures, weight.sum(1))
            offset_s, sigma_s = _moments(offsets, weight.sum(0))
            half = max(_WIDE * exposure_sigma, 2.0 * float(exposures[1] - exposures[0]))
            low, high = max(exposure_s - half, SHORTEST_EXPOSURE_S), exposure_s + half
            reach = max(_WIDE * sigma_s, 4.0 * reach / _OFFSETS)
        return exposure_s, offset_s, sigma_s

    def _noise(self, offset_s: float, drift: float, exposure_s: float) -> float:
        """Variance of the brightness; that of partly lit frames where it is larger.

        They alone hold the offset, and jitter of the stamps and the camera's gamma are in them.
        """
        share = self.share(offset_s, np.array([drift]), exposure_s)[0]
        centred = share - share.mean()
        slope = float(centred @ self.away) / max(float(centred @ centred), 1e-9)
        residual = self.away - slope * centred
        variance = float(residual @ residual) / max(share.size - 4, 1)
        partly = residual[(share > _PARTLY[0]) & (share < _PARTLY[1])]
        if partly.size >= _LEAST_PARTLY:
            variance = max(variance, float(partly @ partly) / max(partly.size - 4, 1))
        return float(max(variance, 1e-9 * self.total / share.size, 1e-12))


def _moments(values: Array, weights: Array) -> tuple[float, float]:
    """Mean and standard deviation of ``values`` on an even grid with these weights."""
    weights = weights / weights.sum()
    mean = float(weights @ values)
    step = float(values[1] - values[0])
    variance = float(weights @ (values - mean) ** 2)
    return mean, float(np.sqrt(max(variance, step**2 / 12.0)))
