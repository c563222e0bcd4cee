"""A model in a control engineer's figures, each with the standard deviation that the fit leaves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from servosight.identify.uncertainty import Matrix
from servosight.models.core import CORE, Actuator, Array, Estimate, Recording
from servosight.models.effects import Effect
from servosight.models.plant import (
    bandwidth_hz,
    command_recording,
    integral_s,
    natural_frequency_hz,
    predict_from_rest,
    resonance_db,
    step_metrics,
)

POINTS = 2001
LENGTH = 12.0
"""Duration of the step response in time constants, of the slow pole where there are two."""
BEFORE_STEP = 0.05
"""Time from the start of the response to the step, as a share of that duration."""
STEP_SHARE = 0.25
"""The step is this share of the command's range: within what the recordings have used."""
_SMALLEST_STEP = 1e-4
"""Difference quotients step by one sigma, and by no less than this share of the value."""


@dataclass(frozen=True, kw_only=True)
class Dynamics:
    """Figures of the linear core, and of the whole model's response to a step of the command.

    Of the core: ``natural_frequency_hz``, ``bandwidth_hz`` (where the gain has fallen by 3 dB) and
    ``resonance_db`` (0 without a peak). Of the response to a step by ``step_deg`` from rest:
    ``rise_time_s`` (10 to 90 %), ``overshoot`` (share of the way), ``settling_time_s`` (to 2 %) and
    ``final_change_deg``. None where the response does not get there. Sigmas are to first order
    (delta method), None where a parameter that matters has none.
    """

    natural_frequency_hz: Estimate
    bandwidth_hz: Estimate
    resonance_db: Estimate
    step_deg: float
    rise_time_s: Estimate | None
    overshoot: Estimate | None
    settling_time_s: Estimate | None
    final_change_deg: Estimate | None


UNITS = {
    "natural_frequency_hz": "Hz",
    "bandwidth_hz": "Hz",
    "resonance_db": "dB",
    "rise_time_s": "s",
    "overshoot": "-",
    "settling_time_s": "s",
    "final_change_deg": "deg",
}


def dynamics(
    actuator: Actuator,
    covariance: Matrix | None,
    step_deg: float,
    catalogue: Mapping[str, Effect],
) -> Dynamics:
    """Figures of a model; ``covariance`` is that of its shared parameters, None where unknown."""
    times_s = step_times(actuator)
    values = {name: actuator.value(name) for name in actuator.parameters}
    centre = _figures(values, actuator, times_s, step_deg, catalogue)
    if covariance is None:
        sigmas = np.full(len(UNITS), np.nan)
    else:
        slopes = [
            _slope(name, values, actuator, (times_s, step_deg, catalogue))
            for name in covariance.names
        ]
        sigmas = _propagated(np.array(slopes), covariance.values)
    found = {
        name: Estimate(float(value), float(sigma) if np.isfinite(sigma) else None, unit)
        if np.isfinite(value)
        else None
        for (name, unit), value, sigma in zip(UNITS.items(), centre, sigmas, strict=True)
    }
    return Dynamics(step_deg=step_deg, **found)  # type: ignore[arg-type]


def step_size_deg(recordings: Sequence[Recording]) -> float:
    """The step of the command for recordings: a quarter of the largest range [deg]."""
    return STEP_SHARE * max(float(np.ptp(one.command_deg)) for one in recordings)


def step_times(actuator: Actuator) -> Array:
    """Times about a step at 0 [s], (POINTS,)."""
    T, xi = actuator.value("T"), actuator.value("xi")
    slow_s = T * (xi + np.sqrt(xi * xi - 1.0)) if xi > 1.0 else T / max(xi, 0.2)
    slow_s = max(slow_s, integral_s(actuator))
    return np.asarray(np.linspace(-BEFORE_STEP, 1.0, POINTS) * LENGTH * slow_s)


def step_response(
    actuator: Actuator, times_s: Array, step_deg: float, catalogue: Mapping[str, Effect]
) -> Array:
    """The angle [deg] after a step of the command at time 0, from where it rests before."""
    command = np.where(times_s < 0.0, 0.0, step_deg)
    since_s = times_s - times_s[0]
    angle = predict_from_rest(actuator, command_recording(since_s, command, since_s), catalogue)
    return np.asarray(angle - angle[times_s < 0.0][-1])


def _figures(
    values: Mapping[str, float],
    actuator: Actuator,
    times_s: Array,
    step_deg: float,
    catalogue: Mapping[str, Effect],
) -> Array:
    """In the order of ``UNITS``, NaN where the response does not get there."""
    moved = {name: Estimate(value, None, "") for name, value in values.items()}
    angle = step_response(Actuator(moved, actuator.effects), times_s, step_deg, catalogue)
    later = times_s >= 0.0
    step = step_metrics(times_s[later], angle[later])
    T, xi = values["T"], values["xi"]
    found = [natural_frequency_hz(T), bandwidth_hz(T, xi), resonance_db(xi)]
    found += [np.nan if one is None else one for one in (step.rise_s, step.overshoot)]
    found += [np.nan if step.settling_s is None else step.settling_s, step.final_deg]
    return np.array(found)


def _slope(
    name: str,
    values: Mapping[str, float],
    actuator: Actuator,
    how: tuple[Array, float, Mapping[str, Effect]],
) -> Array:
    """Change of each figure with a parameter: a difference quotient over a sigma."""
    times_s, step_deg, catalogue = how
    own = {parameter.name: parameter for parameter in CORE}
    for effect in actuator.effects:
        own |= {f"{effect}.{q.name}": q for q in catalogue[effect].parameters}
    value, sigma = values[name], actuator.parameters[name].sigma
    if sigma is not None and sigma == 0.0:
        return np.zeros(len(UNITS))  # held
    step = max(sigma or 0.0, _SMALLEST_STEP * abs(value), 1e-9)
    ends = [min(value + step, own[name].high), max(value - step, own[name].low)]
    upper, lower = (
        _figures({**values, name: end}, actuator, times_s, step_deg, catalogue) for end in ends
    )
    return np.asarray((upper - lower) / max(ends[0] - ends[1], 1e-300))


def _propagated(slopes: Array, covariance: Array) -> Array:
    """Sigma of each figure; NaN where one that moves it has no covariance."""
    known = np.isfinite(np.diag(covariance))
    inner = np.where(np.isfinite(covariance), covariance, 0.0)
    variance = np.einsum("if,ij,jf->f", slopes, inner, slopes)
    lost = np.any(np.abs(slopes[~known]) > 0.0, axis=0)
    return np.where(lost, np.nan, np.sqrt(np.maximum(variance, 0.0)))
