"""The coefficients that both files hold, and their equation run on a command."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.export.core import (
    ExportRequest,
    ExportTrial,
    Omission,
    Response,
    omitted,
)
from servosight.models.core import Array
from servosight.models.plant import Difference, Linear, to_difference

DELAY = "dead_time"
USUAL_STEP_S = 0.01
"""The paper's."""
WHOLE = 1e-9
"""A delay is taken for whole samples within this share of one."""


@dataclass(frozen=True)
class Coefficients:
    """y(k) = bias + x(k), x(k) + a1 x(k-1) + a2 x(k-2) = b0 u(k-d) + b1 u(k-d-1) + b2 u(k-d-2).

    ``delay_samples`` is d, the dead time in whole samples; ``bias_deg`` the angle at zero command.
    """

    equation: Difference
    delay_samples: int
    bias_deg: float


def coefficients_of(request: ExportRequest) -> Coefficients:
    """The linear core, its dead time and bias, sampled as the request says."""
    actuator, options = request.actuator, request.options
    k, T, xi = (actuator.value(name) for name in ("k", "T", "xi"))
    step_s = options.step_s(USUAL_STEP_S)
    equation = to_difference(Linear(k, T, xi), step_s, options.transform)
    return Coefficients(equation, round(_delay_samples(request)), actuator.value("bias"))


def omissions(request: ExportRequest) -> tuple[Omission, ...]:
    """All effects but the dead time, and that too where it is no whole number of samples."""
    exact = _delay_samples(request)
    fractional = abs(exact - round(exact)) > WHOLE
    words = {DELAY: f"{round(exact)} whole samples in place of {exact:.3g}"}
    return omitted(request, () if fractional else (DELAY,), words)


def sampled_trial(coefficients: Coefficients, trial: ExportTrial) -> tuple[Array, Array]:
    """Sample times of a trial [s] and its command there [deg], both (samples,)."""
    first, last = trial.recording.time_s[[0, -1]]
    step = coefficients.equation.sample_time_s
    time_s = first + step * np.arange(int((last - first) / step) + 1)
    return time_s, trial.recording.command_at(time_s)


def response_of(
    coefficients: Coefficients, time_s: Array, command: Array, trial: ExportTrial
) -> Response:
    """The angle by the difference equation, from rest at the first command."""
    from scipy.signal import lfilter

    equation = coefficients.equation
    late = np.maximum(np.arange(command.size) - coefficients.delay_samples, 0)
    change = lfilter(
        [equation.b0, equation.b1, equation.b2],
        [1.0, equation.a1, equation.a2],
        command[late] - command[0],
    )
    return Response(time_s=time_s, angle_deg=trial.start_deg + np.asarray(change))


def _delay_samples(request: ExportRequest) -> float:
    actuator = request.actuator
    delay_s = actuator.value(f"{DELAY}.delay") if DELAY in actuator.effects else 0.0
    return delay_s / request.options.step_s(USUAL_STEP_S)
