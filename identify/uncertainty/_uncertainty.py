"""Uncertainty of a fit: from the Jacobian where the cost is parabolic, else from the profile."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from servosight.identify.problem import Coordinate, Problem
from servosight.identify.uncertainty._clock import like_a_shift, of_clocks, offset_slopes
from servosight.identify.uncertainty._correlation import by_recording
from servosight.identify.uncertainty._matrix import Matrix, inverse_within
from servosight.identify.uncertainty._profile import LikelihoodProfile
from servosight.identify.uncertainty._sampling import misfit_share, sampling_covariance
from servosight.models.core import CHI_SQUARE_95, Array, Estimate, rms

_PARABOLA = (0.6, 1.6)
"""A step of one sigma costs 1 on a parabola; outside this range the profile is used."""
_VAGUE = 10.0
"""A sigma above this multiple of the value is not reported."""
_ROUNDING_DEG2 = 1e-24
"""Variance of what rounding leaves of an angle of some degrees."""


@dataclass(frozen=True)
class Uncertainty:
    """The uncertainty of a fitted ``point`` (coordinates,).

    ``jacobian`` (scored, coordinates) of the weighted residuals, ``cost`` half their sum of
    squares at the point.
    """

    problem: Problem
    point: Array
    jacobian: Array
    cost: float

    @cached_property
    def free(self) -> NDArray[np.bool_]:
        """False for coordinates that rest on a bound."""
        low, high = self.problem.bounds
        return np.asarray((self.point > low) & (self.point < high))

    @cached_property
    def variance(self) -> float:
        """Of the residuals [deg^2]; that of rounding where a model fits exactly."""
        degrees_of_freedom = max(self.jacobian.shape[0] - int(self.free.sum()), 1)
        return max(float(2.0 * self.cost / degrees_of_freedom), _ROUNDING_DEG2)

    @cached_property
    def inverse(self) -> Array:
        """(J'J)^-1, NaN where the data do not determine a coordinate (:func:`inverse_within`)."""
        own = np.array([one.recording is not None for one in self.problem.coordinates])
        return inverse_within(self.jacobian, self.point, self.problem.bounds, own, self.variance)

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the coordinates, NaN where undetermined.

        That of the samples, and errors that all samples of a recording share (of calibration and of
        the clocks): no number of samples averages these out.
        """
        calibration, clocks = self._propagated(self.problem.shared), self._propagated(self._timing)
        return self.sampling + calibration @ calibration.T + clocks @ clocks.T

    @cached_property
    def sampling(self) -> Array:
        """Its part that differs from sample to sample (:func:`sampling_covariance`)."""
        known = np.isfinite(np.diag(self.inverse))
        masks, recordings = self.problem.masks, self.problem.recordings
        residuals = self.problem.residuals(self.point[None, :])[0]
        result = np.full(self.inverse.shape, np.nan)
        result[np.ix_(known, known)] = sampling_covariance(
            *by_recording(masks, self.jacobian[:, known], residuals),
            masks,
            [recording.time_s for recording in recordings],
            self.inverse[np.ix_(known, known)],
            np.arange(known.size)[known] < self.problem.physical,
            self.misfit,
            int(self.free.sum()),
        )
        result[self.problem.is_held, :] = result[:, self.problem.is_held] = 0.0  # taken as exact
        return result

    def _propagated(self, common: Array) -> Array:
        """Errors of the point from residuals (scored, errors) that all samples share; 0 where held.

        (coordinates, errors).
        """
        moved = np.nan_to_num(self.inverse) @ (self.jacobian.T @ common)
        moved[self.problem.is_held] = 0.0
        return np.asarray(moved)

    @cached_property
    def misfit(self) -> float:
        """Share of the squared residuals that the noise does not account for."""
        problem = self.problem
        parts = zip(problem.sample_noises_deg, problem.weights, problem.masks, strict=True)
        noise = np.concatenate([(weight * sigma)[mask] for sigma, weight, mask in parts])
        mean_square = 2.0 * self.cost / max(noise.size, 1)
        return misfit_share(mean_square, rms(noise))

    @cached_property
    def _offsets(self) -> tuple[Array, Array]:
        """Slopes of the residuals over the clocks' offsets, and their sigmas."""
        return offset_slopes(self.problem, self.point)

    @property
    def _timing(self) -> Array:
        """What one sigma of each known offset makes of the residuals, (scored, offsets)."""
        slopes, sigmas_s = self._offsets
        return np.asarray(slopes[:, np.isfinite(sigmas_s)] * sigmas_s[np.isfinite(sigmas_s)])

    @cached_property
    def confounded_with_offset(self) -> NDArray[np.bool_]:
        """True for shared coordinates that cannot be distinguished from an unknown clock offset."""
        slopes, sigmas_s = self._offsets
        known = np.isfinite(np.diag(self.inverse))
        found = like_a_shift(self.jacobian, known, slopes[:, np.isinf(sigmas_s)])
        found[self.problem.physical :] = False
        return found

    @cached_property
    def sigma(self) -> Array:
        """One standard deviation of each coordinate, NaN where it is undetermined."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @cached_property
    def plain_sigma(self) -> Array:
        """The same if the residuals were white."""
        return np.asarray(np.sqrt(self.variance * np.diag(self.inverse)))

    @cached_property
    def _wider(self) -> Array:
        """By how much correlation and misfit widen each sigma."""
        return np.asarray(np.sqrt(np.diag(self.sampling)) / self.plain_sigma)

    @cached_property
    def profile(self) -> LikelihoodProfile:
        """The likelihood about the point."""
        scale = np.where(np.isfinite(self.plain_sigma), self.plain_sigma, 1e-3)
        own = np.diag(self.inverse)
        slopes = np.nan_to_num(self.inverse / np.where(own > 0.0, own, 1.0)[:, None])
        return LikelihoodProfile(self.problem, self.point, self.cost, self.variance, scale, slopes)

    @cached_property
    def parabolic(self) -> NDArray[np.bool_]:
        """True where a step of one sigma to either side costs about what the Jacobian predicts:
        1, or more by what correlation and misfit widen."""
        indices = np.flatnonzero(np.isfinite(self.plain_sigma))
        low, high = self.problem.bounds
        wider = self._wider[indices]
        steps = self.variance * self.inverse[indices] / self.plain_sigma[indices, None]
        steps = np.nan_to_num(steps * wider[:, None])
        points = np.vstack([self.point + steps, self.point - steps])
        inside = np.all((points >= low) & (points <= high) | ~self.free, axis=1)
        costs = 0.5 * np.sum(self.problem.residuals(np.clip(points, low, high)) ** 2, axis=1)
        rises = 2.0 * (costs - self.cost) / self.variance / np.tile(wider, 2) ** 2
        good = inside & (rises > _PARABOLA[0]) & (rises < _PARABOLA[1])
        result = np.zeros(self.point.size, dtype=bool)
        result[indices] = good[: indices.size] & good[indices.size :]
        return result

    def profiled_sigma(self, index: int) -> float | None:
        """Half the interval at a rise of 1, or of what correlation and misfit widen; None where it
        is open (Pace and others, Statistica Sinica 21 (2011) 129).

        Where one side ends at a bound, the other side's distance.
        """
        wider = float(self._wider[index])
        own = wider * float(self.plain_sigma[index])
        reaches = [self.profile.reach(index, step, wider**2) for step in (own, -own)]
        found = [reach for reach in reaches if reach is not None]
        return float(np.mean(found) * self.sigma[index] / own) if found else None

    def estimate(self, index: int, profiled: bool = True) -> tuple[Estimate, str | None]:
        """A coordinate's value with its sigma, and a warning where it has none."""
        coordinate, x = self.problem.coordinates[index], float(self.point[index])
        value = coordinate.from_search(x)
        if not np.isfinite(value):
            value = coordinate.from_search(1e-9)
        sigma, warning = self._sigma(index, coordinate, value, profiled)
        return Estimate(value, sigma, coordinate.parameter.unit), warning

    def shared_estimates(self, profiled: bool = True) -> tuple[dict[str, Estimate], list[str]]:
        """Shared parameters by name, and a warning for each whose sigma is unknown.

        A further one names those whose sigma is the clocks'. Where they are not ``profiled`` each
        sigma is the Jacobian's, which costs no further fit.
        """
        names = [coordinate.name for coordinate in self.problem.coordinates]
        found = [self.estimate(index, profiled) for index in range(self.problem.physical)]
        table = {name: one for name, (one, _) in zip(names, found, strict=False)}
        warnings = [warning for _, warning in found if warning is not None]
        return table, warnings + self._of_clocks(table)

    def _of_clocks(self, table: Mapping[str, Estimate]) -> list[str]:
        """A sentence on the parameters that the offset of the clocks leaves uncertain."""
        _, offset_sigmas_s = self._offsets
        return of_clocks(table, self._share(self._propagated(self._timing)), offset_sigmas_s)

    def _share(self, moved: Array) -> Array:
        """The share of each coordinate's variance that comes from errors all samples share."""
        sigmas = np.where(self.sigma > 0.0, self.sigma, np.inf)
        return np.asarray(np.sum(moved**2, axis=1) / sigmas**2)

    def shared_shares(self, estimates: Mapping[str, Estimate]) -> dict[str, float]:
        """The same of the shared parameters that have a sigma, calibration and clocks together."""
        shares = self._share(self._propagated(np.hstack([self.problem.shared, self._timing])))
        names = [coordinate.name for coordinate in self.problem.coordinates]
        found = zip(names[: self.problem.physical], shares, strict=False)
        return {name: float(share) for name, share in found if estimates[name].sigma}

    def own_estimates(self, name: str) -> tuple[Estimate, ...]:
        """One of the recordings' own parameters (``bias``), for each recording."""
        return tuple(
            Estimate(float(x), float(sigma) if np.isfinite(sigma) else None, one.parameter.unit)
            for one, x, sigma in zip(self.problem.coordinates, self.point, self.sigma, strict=True)
            if one.recording is not None and one.name == name
        )

    def matrix(self, estimates: Mapping[str, Estimate], *, sampling: bool = False) -> Matrix:
        """Covariance of the shared parameters in their own units; or its ``sampling`` part alone.

        NaN for those without a sigma among ``estimates``, 0 for those held. Linear throughout:
        where a sigma comes from the profile likelihood, it differs from the root of the diagonal.
        """
        covariance = self.sampling if sampling else self.covariance
        count = self.problem.physical
        slopes = np.array(
            [
                coordinate.slope(float(x))
                if estimates[coordinate.name].sigma is not None
                else np.nan
                for coordinate, x in zip(self.problem.coordinates[:count], self.point, strict=False)
            ]
        )
        names = tuple(coordinate.name for coordinate in self.problem.coordinates[:count])
        return Matrix(names, covariance[:count, :count] * np.outer(slopes, slopes))

    def _sigma(
        self, index: int, coordinate: Coordinate, value: float, profiled: bool
    ) -> tuple[float | None, str | None]:
        if self.problem.is_held[index]:
            return 0.0, None
        if not self.free[index]:
            return None, f"{coordinate.name} is at a bound of its range" + self._limit(index)
        if coordinate.parameter.reciprocal and self.profile.rise(index, 0.0) < CHI_SQUARE_95:
            return None, (
                f"{coordinate.name} cannot be determined from this recording: a model without it "
                f"fits as well{self._limit(index)}; use a command that reaches it"
            )
        if self.confounded_with_offset[index]:
            return None, (
                f"{coordinate.name} cannot be distinguished from the latency of camera or log: the "
                f"offset between the time stamps of command and angle is not known; film a "
                f"light that the command switches, or state offset_sigma_s in recording.toml"
            )
        sigma: float | None = None
        if np.isfinite(self.plain_sigma[index]):
            sigma = float(self.sigma[index])
            if profiled and not self.parabolic[index]:
                sigma = self.profiled_sigma(index)
        if sigma is not None:
            sigma *= abs(coordinate.slope(float(self.point[index])))
        if sigma is None or not np.isfinite(sigma) or sigma > _VAGUE * (abs(value) + 1e-9):
            return None, (
                f"{coordinate.name} cannot be determined from this recording: changing it hardly "
                f"changes the prediction; use a command on which it has an influence"
            )
        return sigma, None

    def _limit(self, index: int) -> str:
        """What the profile allows at most (or at least), in words; empty where it does not end."""
        coordinate, x = self.problem.coordinates[index], float(self.point[index])
        low, high = self.problem.bounds
        alone = np.sqrt(self.variance / max(float(np.sum(self.jacobian[:, index] ** 2)), 1e-300))
        inward = 1.0 if coordinate.parameter.reciprocal or x <= low[index] else -1.0
        step = inward * min(float(alone), 0.5 * float(high[index] - low[index]))
        reach = self.profile.reach(index, step, CHI_SQUARE_95)
        if reach is None:
            return ""
        end = coordinate.from_search(x + inward * reach)
        upward = (inward > 0.0) != coordinate.parameter.reciprocal
        word = "at most" if upward else "at least"
        return f", {word} {end:.3g}{coordinate.parameter.suffix} with 95 % confidence"
