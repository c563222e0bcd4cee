"""How far a fit moves without one block of time after the other, to first order.

An error that is no noise is alike within a second and differs from second to second: so blocks
show what it does to the parameters, also where it stays below the noise of the single samples.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import chdtri, ndtr, stdtrit

from servosight.models.core import Array, Mask

BLOCK_S = 1.0
"""Longer than an error of a servo is correlated with itself, shorter than most recordings."""
_FEWEST_BLOCKS = 10
_MOST_BLOCKS = 1000
_LEVERAGE = 0.9
"""A block that alone determines a parameter is not left out whole."""
_SIGMAS = 2.0
_LEAST_FREEDOM = 2.0
_RARE = 0.05


@dataclass(frozen=True)
class BlockMoves:
    """Moves of the coordinates, each (blocks, coordinates).

    ``unbiased``: the sum of their squares is the variance, if errors are white (Bell and McCaffrey,
    Survey Methodology 28 (2002) 169, CR2). ``without``: the fit less one block (Cameron and Miller,
    Journal of Human Resources 50 (2015) 317, CR3). ``shares`` of each coordinate's variance by
    block, if errors are white.
    """

    unbiased: Array
    without: Array
    shares: Array

    @cached_property
    def freedom(self) -> Array:
        """How many blocks determine each coordinate (Satterthwaite), (coordinates,)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            found = np.sum(self.shares, axis=0) ** 2 / np.sum(self.shares**2, axis=0)
        return np.asarray(np.nan_to_num(found))

    def by_chance(self, among: Mask) -> float:
        """What the :meth:`excess` over the right covariance stays below in 95 of 100 cases."""
        freedom = max(float(np.sum(self.freedom[among])), 1.0)
        return float(chdtri(freedom, _RARE)) / freedom

    def variances(self, otherwise: Array) -> Array:
        """The jackknife's variance of each coordinate, (coordinates,).

        Widened so that two sigma hold what they hold of a normal error: a variance of few blocks
        is itself uncertain, and so is one that few of many blocks make. Where fewer than two
        determine a coordinate, as an initial speed, none can be left out: then ``otherwise``.
        """
        count = max(self.without.shape[0], 1)
        enough = self.freedom >= _LEAST_FREEDOM
        wider = stdtrit(np.maximum(self.freedom, _LEAST_FREEDOM), ndtr(_SIGMAS)) / _SIGMAS
        found = (count - 1) / count * np.sum(self.without**2, axis=0) * wider**2
        return np.where(enough, found, otherwise)

    def excess(self, noise: Array, inverse: Array, among: Mask) -> float:
        """Variance of the coordinates ``among`` by blocks over that by ``noise``.

        In the mean over independent directions; about 1 where ``noise`` (coordinates, coordinates)
        is the covariance. ``inverse`` is (J'J)^-1.
        """
        chosen = np.ix_(among, among)
        if not among.any() or not np.any(noise):
            return 1.0
        to_unit = np.linalg.inv(_root(inverse[chosen]))
        blocks = float(np.sum((self.unbiased[:, among] @ to_unit.T) ** 2))
        return blocks / float(np.trace(to_unit @ noise[chosen] @ to_unit.T))


def block_moves(
    jacobians: Sequence[Array],
    residuals: Sequence[Array],
    times_s: Sequence[Array],
    inverse: Array,
) -> BlockMoves:
    """Moves by each block of the recordings.

    For each recording the Jacobian (samples, coordinates) and the residuals (samples,), both zero
    where a sample is not scored, and its times [s]. ``inverse`` is (J'J)^-1.
    """
    root = _root(inverse)
    unbiased, without, shares = [], [], []
    for jacobian, errors in _blocks(jacobians, residuals, times_s):
        scaled = jacobian @ root
        values, vectors = np.linalg.eigh(scaled.T @ scaled)
        values = np.clip(values, 0.0, _LEVERAGE)
        axes, score = root @ vectors, vectors.T @ (scaled.T @ errors)
        unbiased.append(axes @ (score / np.sqrt(1.0 - values)))
        without.append(axes @ (score / (1.0 - values)))
        shares.append(axes**2 @ values)
    shape = len(shares), inverse.shape[0]
    return BlockMoves(*(np.reshape(rows, shape) for rows in (unbiased, without, shares)))


def _blocks(
    jacobians: Sequence[Array], residuals: Sequence[Array], times_s: Sequence[Array]
) -> Iterator[tuple[Array, Array]]:
    """Jacobian and errors of each block with scored samples."""
    duration_s = sum(float(time_s[-1] - time_s[0]) for time_s in times_s)
    block_s = min(BLOCK_S, duration_s / _FEWEST_BLOCKS)
    block_s = max(block_s, duration_s / _MOST_BLOCKS)
    for jacobian, errors, time_s in zip(jacobians, residuals, times_s, strict=True):
        number = ((time_s - time_s[0]) // block_s).astype(np.int64)
        edges = np.flatnonzero(np.diff(number, prepend=-1))[1:]
        for part, error in zip(np.split(jacobian, edges), np.split(errors, edges), strict=True):
            if error.any():
                yield part, error


def _root(matrix: Array) -> Array:
    """A lower triangle whose square is a covariance, also one that rounding left singular."""
    return np.asarray(np.linalg.cholesky(matrix + 1e-12 * np.diag(np.diag(matrix))))
