"""Recordings that are fitted together and whose angles lag by different times.

A host that writes the goal before it reads the position, or another load of the bus, gives each log
a latency of its own, which a joint fit takes for the same. It shows as a shift of the recording's
clock: by Gauss and Newton's step on the fit's own linearization, repeated on shifted recordings.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from servosight.identify.fit._solution import Solution, polish
from servosight.identify.problem import projected_out
from servosight.identify.uncertainty import by_recording, clock_slope, weighted_normal
from servosight.models.core import Array, uncertain

CLEAR = 3.0
"""So many of its sigmas a latency must be, and"""
GAIN = 0.05
"""the error must fall by this share, before it is said."""
ROUNDS = 3


def latency_notes(fit: Solution) -> tuple[str, ...]:
    """A sentence for each recording of a joint fit whose angle clearly lags those of others.

    Latencies count from the recording that lags least: what all have in common is dead time.
    """
    names = [one.name for one in fit.problem.recordings]
    if len({one.side for one in fit.problem.recordings}) > 1 or len(names) < 2:
        return ()
    late_s, sigma_s, left = own_latencies(fit)
    worth = (1.0 - GAIN) * fit.rmse_deg
    if not np.any(late_s - late_s.min() > CLEAR * sigma_s) or left * fit.rmse_deg > worth:
        return ()
    total_s, moved = late_s, fit
    for _ in range(ROUNDS):
        moved = _shifted(fit, total_s)
        late_s, sigma_s, _ = own_latencies(moved)
        total_s = total_s + late_s
    total_s = total_s - total_s.min()
    if moved.rmse_deg > worth:
        return ()
    notes = []
    for name, late, sigma in zip(names, total_s, sigma_s, strict=True):
        if late > CLEAR * sigma:
            shown = " +- ".join(uncertain(1e3 * late, 1e3 * sigma))
            notes.append(
                f"{name}: its angle comes {shown} ms later after the command than that of other "
                f"recordings, which the fit takes for the same (with latencies of their own the "
                f"rmse is {moved.rmse_deg:.3g} deg instead of {fit.rmse_deg:.3g}); give latency_s "
                f"= {late:.4g} in its recording.toml"
            )
    return tuple(notes)


def own_latencies(fit: Solution) -> tuple[Array, Array, float]:
    """By how much each recording's angle lags behind the mean of all, (recordings,) [s].

    Also sigma of the difference to any other, (recordings,) [s], and the share of the rms error
    that would be left. To first order, with all parameters of the fit free to follow; errors that
    are correlated over time widen sigma.
    """
    problem, point = fit.problem, fit.outcome.point
    count = len(problem.recordings)
    slopes = np.stack([clock_slope(problem, point, r) for r in range(count)], axis=1)
    from_mean = np.eye(count)[:, 1:] - 1.0 / count
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


def _shifted(fit: Solution, late_s: Array) -> Solution:
    """The fit with each recording's angle earlier by its latency."""
    recordings = tuple(
        one.shifted(-late)
        for one, late in zip(fit.problem.recordings, late_s.tolist(), strict=True)
    )
    return polish(replace(fit.problem, recordings=recordings), [fit.outcome.point])
