"""Angles that move before the command could have moved them: a clock that is wrong.

No model of a servo foresees its command. A fit to such a recording has neither T nor xi left and
looks like many missing effects, while one to angles that are shifted later is good.
"""

from __future__ import annotations

from dataclasses import replace

from scipy.optimize import minimize_scalar

from servosight.identify.fit._solution import Solution, polish
from servosight.identify.problem import Problem, linear_start

LEFT = 0.4
"""The error falls to this share where a clock is early. In simulated recordings with each effect
of the catalogue it falls to 0.48 with ``velocity_feedforward``, and to 0.88 or more with others."""
_MISSES = 2.0
"""An early clock is ruled out where the fit's error is below this multiple of the floor."""
_FIRST_S = 0.005
_FALLS = 0.98
"""Below this share the error falls with the first shift wherever the clock is early."""
_LATER_S = (0.01, 0.02, 0.04, 0.08, 0.16)
"""Where the last is the best, there is no best: a slow motion with much else missing."""
_TOLERANCE_S = 5e-4


def early_notes(fit: Solution, floor_deg: float) -> tuple[str, ...]:
    """A sentence where the linear model fits angles that are later far better than the measured.

    Empty where the error of ``fit`` is near its floor [deg].
    """
    if fit.rmse_deg <= _MISSES * floor_deg:
        return ()
    linear = fit.problem.linear
    measured_deg = _shifted_rmse_deg(linear, 0.0)
    first_deg = _shifted_rmse_deg(linear, _FIRST_S)
    if first_deg > _FALLS * measured_deg:
        return ()
    trials = {_FIRST_S: first_deg, **{one: _shifted_rmse_deg(linear, one) for one in _LATER_S}}
    near_s = min(trials, key=lambda one: trials[one])
    if near_s == _LATER_S[-1]:
        return ()
    best = minimize_scalar(
        lambda shift_s: _shifted_rmse_deg(linear, shift_s),
        bounds=(0.5 * near_s, 2.0 * near_s),
        method="bounded",
        options={"xatol": _TOLERANCE_S},
    )
    if best.fun > LEFT * measured_deg:
        return ()
    names = ", ".join(dict.fromkeys(one.name for one in linear.recordings))
    return (
        f"{names}: the angle moves about {1e3 * best.x:.2g} ms before a servo could answer the "
        f"command (with angles that much later the linear model's rmse is {best.fun:.3g} deg "
        f"instead of {measured_deg:.3g}); check whether command and angle are exchanged or have "
        f"different clocks, and correct a clock by latency_s = {-best.x:.2g} in recording.toml",
    )


def _shifted_rmse_deg(linear: Problem, by_s: float) -> float:
    """The error of the linear model fitted to angles that are later by ``by_s`` [deg]."""
    recordings = tuple(one.shifted(by_s) for one in linear.recordings)
    problem = replace(linear, recordings=recordings)
    return polish(problem, [linear_start(problem)]).rmse_deg
