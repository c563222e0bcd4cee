"""Recordings that are fitted together and whose angles lag by different times.

A host that writes the goal before it reads the position, or another load of the bus, gives each log
a latency of its own, which a joint fit takes for the same. It shows as a shift of the recording's
clock: by Gauss and Newton's step on the fit's own linearization, repeated on shifted recordings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from servosight.identify.fit._solution import Solution, polish
from servosight.identify.problem import projected_out
from servosight.identify.uncertainty import by_recording, clock_slope, weighted_normal
from servosight.models.core import Array, uncertain

CLEAR = 3.0
"""A latency is reported only if it is larger than this multiple of its sigma."""
GAIN = 0.05
"""Latencies are reported only if the error falls with them by at least this share."""
ROUNDS = 3


@dataclass(frozen=True)
class OwnLatencies:
    """Latencies that the recordings of a fit clearly do not share.

    ``late_s`` and ``sigma_s`` (recordings,): by how much each angle lags behind that of the
    recording that lags least, since what all have in common is dead time. ``rmse_deg`` is the error
    of the fit to recordings that are shifted by as much, ``shared_rmse_deg`` that without it.
    """

    late_s: Array
    sigma_s: Array
    rmse_deg: float
    shared_rmse_deg: float

    def sentences(self, names: Sequence[str], remedy: str) -> tuple[str, ...]:
        """One for each run that lags; ``remedy`` says what is done, with {late_s} in it.

        ``names`` (recordings,) are those of the runs, the same for the parts of one.
        """
        found = []
        for name, late, sigma in zip(names, self.late_s, self.sigma_s, strict=True):
            if late > CLEAR * sigma:
                shown = " +- ".join(uncertain(1e3 * late, 1e3 * sigma))
                found.append(
                    f"{name}: its angle comes {shown} ms later after the command than that of "
                    f"other recordings (with latencies of their own the rmse is "
                    f"{self.rmse_deg:.3g} deg instead of {self.shared_rmse_deg:.3g}); "
                    f"{remedy.format(late_s=f'{late:.4g}')}"
                )
        return tuple(dict.fromkeys(found))


def latency_notes(fit: Solution) -> tuple[str, ...]:
    """A sentence for each recording of a joint fit whose angle clearly lags those of others."""
    found = clear_latencies(fit)
    names = [one.name for one in fit.problem.recordings]
    remedy = "the fit takes them for the same: give latency_s = {late_s} in its recording.toml"
    return () if found is None else found.sentences(names, remedy)


def clear_latencies(fit: Solution, runs: Sequence[int] | None = None) -> OwnLatencies | None:
    """The latencies of a joint fit's recordings where they clearly differ, else None.

    ``runs`` (recordings,) numbers the run that each is a part of, and parts of one run share their
    latency; by default each is a run.
    """
    recordings = fit.problem.recordings
    runs = range(len(recordings)) if runs is None else runs
    if len({one.side for one in recordings}) > 1 or len(set(runs)) < 2:
        return None
    late_s, sigma_s, left = _own_latencies(fit, runs)
    worth = (1.0 - GAIN) * fit.rmse_deg
    if not np.any(late_s - late_s.min() > CLEAR * sigma_s) or left * fit.rmse_deg > worth:
        return None
    total_s, moved = late_s, fit
    for _ in range(ROUNDS):
        moved = _shifted(fit, total_s)
        late_s, sigma_s, _ = _own_latencies(moved, runs)
        total_s = total_s + late_s
    total_s = total_s - total_s.min()
    if moved.rmse_deg > worth or not np.any(total_s > CLEAR * sigma_s):
        return None
    return OwnLatencies(total_s, sigma_s, moved.rmse_deg, fit.rmse_deg)


def _own_latencies(fit: Solution, runs: Sequence[int]) -> tuple[Array, Array, float]:
    """By how much each recording's angle lags behind the mean of all, (recordings,) [s].

    Also sigma of the difference to any other, (recordings,) [s], and the share of the rms error
    that would be left. To first order, with all parameters of the fit free to follow; errors that
    are correlated over time widen sigma.
    """
    problem, point = fit.problem, fit.outcome.point
    count = len(problem.recordings)
    slopes = np.stack([clock_slope(problem, point, r) for r in range(count)], axis=1)
    from_mean = _from_mean(runs)
    columns = projected_out(slopes @ from_mean, fit.jacobian)
    inverse = np.linalg.pinv(columns.T @ columns)
    found = inverse @ (columns.T @ fit.residual)
    parts = zip(*by_recording(problem.masks, columns, fit.residual), problem.masks, strict=True)
    meat = sum((weighted_normal(*one) for one in parts), np.zeros(inverse.shape))
    spread = from_mean @ inverse @ meat @ inverse @ from_mean.T
    sigma_s = 2.0 * np.sqrt(np.maximum(np.diag(spread), 0.0))
    square = float(fit.residual @ fit.residual)
    gone = float(found @ (columns.T @ fit.residual))
    left = np.sqrt(max(1.0 - gone / max(square, 1e-300), 0.0))
    return from_mean @ found, sigma_s, float(left)


def _from_mean(runs: Sequence[int]) -> Array:
    """What free numbers make of the latencies, (recordings, runs - 1); their mean is 0."""
    numbers = sorted(set(runs))
    own = np.eye(len(numbers))[:, 1:] - 1.0 / len(numbers)
    return np.asarray(own[[numbers.index(one) for one in runs]])


def _shifted(fit: Solution, late_s: Array) -> Solution:
    """The fit with each recording's angle earlier by its latency."""
    recordings = tuple(
        one.shifted(-late)
        for one, late in zip(fit.problem.recordings, late_s.tolist(), strict=True)
    )
    return polish(replace(fit.problem, recordings=recordings), [fit.outcome.point])
