"""The disturbance torque that a fitted model lacks, along the motion of the surface.

A torque d(t) [deg] that the loop lacks shows in the residual r, to first order, as -G d with
G = 1 / (T^2 s^2 + 2 xi T s + 1). The smoothest d that leaves of r no more than noise is the maximum
a posteriori estimate under a random walk d and white noise; the walk's pace is chosen by its
marginal likelihood (Kitagawa and Gersch, Smoothness Priors Analysis of Time Series, 1996, ch. 4).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from servosight.diagnose.discrepancy.basis import BasisMotion
from servosight.diagnose.residuals import TEST
from servosight.diagnose.selection import Trial
from servosight.models.core import Array, Mask, rms
from servosight.models.plant import Stimulus, loop_filter

STEPS_PER_T = 2.0
MOST_INSTANTS = 8
"""Instants of the grid for each time constant, and at most for each sample."""
PACES = np.geomspace(1e-2, 1e4, 13)
"""Tried paces of the walk [noise / sqrt(s)]."""


@dataclass(frozen=True)
class DisturbanceEstimator:
    """The linear loop around one recording on an even grid, and what a model leaves there.

    ``at`` (samples,) says which instant each sample is and ``used`` (samples,) which samples count.
    ``numerator`` and ``denominator`` are of G for torques that are joined by
    lines.
    """

    motion: BasisMotion
    at: NDArray[np.intp]
    used: Mask
    residual_deg: Array
    sigma_deg: Array
    numerator: Array
    denominator: Array

    @classmethod
    def of(
        cls, trial: Trial, number: int, noise_deg: float, *, with_test: bool = True
    ) -> DisturbanceEstimator:
        """The loop of recording ``number`` (in the order of ``trial.judged``) about its model.

        What chooses terms leaves the test's samples out.
        """
        judged = trial.judged[number]
        recording, problem = judged.recording, trial.fit.problem
        row = problem.rows(trial.fit.outcome.point[None, :], number)[0]
        k, T, xi, bias = (float(x) for x in row[:4])
        sample_s = float(np.median(np.diff(recording.time_s)))
        per_sample = int(np.clip(np.ceil(STEPS_PER_T * sample_s / T), 1, MOST_INSTANTS))
        interval = sample_s / per_sample
        at = np.rint((recording.time_s - recording.time_s[0]) / interval).astype(np.intp)
        time_s = recording.time_s[0] + interval * np.arange(int(at[-1]) + 1)
        asked = Stimulus.of(recording)
        asked = replace(asked, samples_s=time_s, weights=np.ones(1))
        model = _held(problem.plant.simulate(row, asked))
        numerator, denominator = loop_filter(T, xi, interval)
        sigma = np.full(recording.time_s.size, max(noise_deg, 1e-9))
        if recording.sigma_deg is not None and np.all(recording.sigma_deg > 0.0):
            sigma = recording.sigma_deg
        estimator = cls(
            _motion(interval, time_s - time_s[0], model, k * recording.command_at(time_s) + bias),
            at,
            np.full(judged.uses.size, with_test) | (judged.uses != TEST),
            judged.error_deg,
            sigma,
            numerator,
            denominator,
        )
        # What the model leaves belongs to the motion.
        path = model - estimator.answers(estimator.torque()[0][None, :])[0]
        force = estimator.motion.force_deg
        return replace(estimator, motion=_motion(interval, estimator.motion.time_s, path, force))

    def answers(self, torques: Array) -> Array:
        """G applied to torques (many, instants), (many, instants) [deg]."""
        from scipy.signal import lfilter

        return np.asarray(lfilter(self.numerator, self.denominator, torques, axis=1))

    def torque(self) -> tuple[Array, float]:
        """The missing torque d [deg], (instants,), and its standard deviation in the middle.

        With G = B / A, the unknown is s in d = A s, G d = B s, so that all matrices are banded.
        """
        best = (-np.inf, self.motion.time_s * 0.0, 0.0)
        for pace in PACES:
            best = max(best, self._smoothed(float(pace)), key=lambda found: found[0])
        return best[1], best[2]

    def _smoothed(self, pace: float) -> tuple[float, Array, float]:
        """Log-likelihood of a pace, the torque and its standard deviation."""
        from scipy.linalg import cho_solve_banded, cholesky_banded

        count = self.motion.time_s.size
        scale = rms(self.sigma_deg)
        step = pace * scale * np.sqrt(self.motion.interval_s)
        weight = self._gathered(1.0 / self.sigma_deg**2)
        pull = self._gathered(-self.residual_deg / self.sigma_deg**2)
        walk = np.convolve([1.0, -1.0], self.denominator) / step
        width = walk.size
        band = _normal(self.numerator, weight, width) + _normal(walk, np.ones(count), width)
        band[0] += 1e-12 * band[0].max()
        factor = cholesky_banded(band, lower=True)
        seed = cho_solve_banded((factor, True), _transposed(self.numerator, pull))
        torque = np.convolve(seed, self.denominator)[:count]
        # Quadratic form at the optimum, and determinants of the posterior and of the prior.
        explained = float(seed @ _transposed(self.numerator, pull))
        likelihood = (
            0.5 * explained - float(np.log(factor[0]).sum()) + count * float(np.log(walk[0]))
        )
        middle = np.zeros(count)
        middle[count // 2] = 1.0
        probe = _transposed(self.denominator, middle)
        spread = float(probe @ cho_solve_banded((factor, True), probe))
        return likelihood, torque, float(np.sqrt(max(spread, 0.0)))

    def _gathered(self, values: Array) -> Array:
        """Sums of the used samples' values (samples,) at each instant, (instants,)."""
        counted = np.where(self.used, values, 0.0)
        return np.bincount(self.at, counted, self.motion.time_s.size).astype(np.float64)


def _held(angle_deg: Array) -> Array:
    """Angles (instants,) that stay where a simulation ran out of steps: one that reached the last
    sample may do so just before the last instant, which lies up to half an interval later."""
    known = np.flatnonzero(np.isfinite(angle_deg))
    return np.interp(np.arange(angle_deg.size), known, angle_deg[known])


def _motion(interval_s: float, time_s: Array, angle_deg: Array, force_deg: Array) -> BasisMotion:
    speed = np.gradient(angle_deg, interval_s)
    slow = 0.01 * float(np.abs(speed).max()) + 1e-9
    return BasisMotion(interval_s, time_s, angle_deg, speed, force_deg, np.tanh(speed / slow))


def _transposed(taps: Array, signal: Array) -> Array:
    """The transpose of filtering by ``taps`` from rest, applied to ``signal``."""
    return np.asarray(np.convolve(signal[::-1], taps)[: signal.size][::-1])


def _normal(taps: Array, weight: Array, width: int) -> Array:
    """F' W F for filtering F by ``taps``, lower bands (width, count)."""
    count = weight.size
    band = np.zeros((width, count))
    for i, first in enumerate(taps):
        for j, second in enumerate(taps[: i + 1]):
            # Output n holds taps[i] of input n - i and taps[j] of input n - j, further down.
            band[i - j, : count - i] += first * second * weight[i:]
    return band
