"""Fits of the difference equation to evenly sampled data, and back to k, T, xi.

The equation and its sampling methods are in models/plant/_difference.py.
"""

from __future__ import annotations

import math

import numpy as np

from servosight.models.core import Array, InputError
from servosight.models.plant import Difference, Linear

_ROUNDS = 20
"""Of the instruments, and of Gauss-Newton."""


def to_linear(difference: Difference, transform: str = "tustin") -> Linear:
    """k, T and xi of a difference equation.

    k is its static gain; T and xi follow from its poles, s = 2/h (z - 1)/(z + 1) under Tustin and
    s = ln(z)/h under the other two. InputError where the poles are those of no such servo: outside
    the unit circle, or negative where a logarithm is asked for.
    """
    poles = np.roots([1.0, difference.a1, difference.a2]).astype(complex)
    h = difference.sample_time_s
    negative = np.any((poles.imag == 0.0) & (poles.real <= 0.0))
    if np.any(np.abs(poles) >= 1.0) or (transform != "tustin" and negative):
        raise InputError(
            f"the difference equation's poles are {poles[0]:.3g} and {poles[1]:.3g}, expected "
            f"stable ones that {transform} makes of a second-order servo; sample faster, or fit "
            f"k, T and xi directly with `servosight identify`"
        )
    if transform == "tustin":
        roots = 2.0 / h * (poles - 1.0) / (poles + 1.0)
    else:
        roots = np.log(poles) / h
    T = 1.0 / math.sqrt(float(np.prod(roots).real))
    return Linear(difference.gain, T, float(-0.5 * T * np.sum(roots).real))


def by_arx(command: Array, angle: Array, sample_time_s: float) -> Difference:
    """Least squares on eq. 2 (Ljung, System Identification, 1999, eq. 4.12).

    ``command`` and ``angle`` (samples,) at the same even times, offsets removed. Noise on the angle
    is also in the regressors and biases the fit: poles come out too fast.
    """
    regressors = _regressors(command, angle)
    return _difference(_least_squares(regressors, angle[2:]), sample_time_s)


def by_instruments(command: Array, angle: Array, sample_time_s: float) -> Difference:
    """Simplified refined instrumental variables (Young, Recursive Estimation, 2011, section 7.4).

    Instruments are what the last model makes of the command, free of the noise; all is filtered by
    1 / A, so that noise that is white on the angle is white in the equation. Starts from ARX.
    """
    model = by_arx(command, angle, sample_time_s)
    for _ in range(_ROUNDS):
        denominator = _stable(model)
        u, y = _filtered(denominator, command), _filtered(denominator, angle)
        clean = _filtered(denominator, simulate(model, command))
        instruments, regressors = _regressors(u, clean), _regressors(u, y)
        found = _least_squares(instruments.T @ regressors, instruments.T @ y[2:])
        model = _difference(found, sample_time_s)
    return model


def by_output_error(command: Array, angle: Array, sample_time_s: float) -> Difference:
    """Least squares on the simulated angle, by Gauss-Newton (Ljung, 1999, eq. 4.25).

    Starts from the instrumental variables; steps are halved until the error falls.
    """
    model = by_instruments(command, angle, sample_time_s)
    error = angle - simulate(model, command)
    for _ in range(_ROUNDS):
        denominator = _stable(model)
        # dy/da_i = -(delayed y) / A, dy/db_i = (delayed u) / A.
        slopes = _regressors(
            _filtered(denominator, command), _filtered(denominator, simulate(model, command))
        )
        step = _least_squares(slopes, error[2:])
        here = np.array([model.a1, model.a2, model.b0, model.b1, model.b2])
        for share in (1.0, 0.5, 0.25, 0.1, 0.02):
            trial = _difference(here + share * step, sample_time_s)
            left = angle - simulate(trial, command)
            if left @ left < error @ error:
                model, error = trial, left
                break
        else:
            break
    return model


METHODS = {"arx": by_arx, "instruments": by_instruments, "output_error": by_output_error}
"""Fits of eq. 2 by name: ``(command, angle, sample_time_s) -> Difference``."""


def simulate(difference: Difference, command: Array) -> Array:
    """Angle (samples,) from rest; poles outside the unit circle are mirrored into it."""
    from scipy.signal import lfilter

    top = [difference.b0, difference.b1, difference.b2]
    return np.asarray(lfilter(top, _stable(difference), command))


def _stable(difference: Difference) -> Array:
    poles = np.roots([1.0, difference.a1, difference.a2]).astype(complex)
    size = np.abs(poles)
    inside = np.where(size > 1.0, poles / np.maximum(size, 1.0) ** 2, poles)
    return np.asarray(np.poly(inside).real, dtype=np.float64)


def _least_squares(regressors: Array, values: Array) -> Array:
    return np.asarray(np.linalg.lstsq(regressors, values, rcond=None)[0], dtype=np.float64)


def _filtered(denominator: Array, values: Array) -> Array:
    from scipy.signal import lfilter

    return np.asarray(lfilter([1.0], denominator, values))


def _regressors(command: Array, angle: Array) -> Array:
    """Columns -y(k-1), -y(k-2), u(k), u(k-1), u(k-2), (samples - 2, 5)."""
    return np.column_stack([-angle[1:-1], -angle[:-2], command[2:], command[1:-1], command[:-2]])


def _difference(found: Array, sample_time_s: float) -> Difference:
    a1, a2, b0, b1, b2 = map(float, found)
    return Difference(sample_time_s, a1, a2, b0, b1, b2)
