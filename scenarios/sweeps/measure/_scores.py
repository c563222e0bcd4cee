"""Errors of a fit against the truth, beside its own sigma and the smallest that there can be."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from servosight.identify.design import assess
from servosight.models.core import Actuator, Estimate, Recording
from servosight.models.effects import catalogue

Columns = dict[str, float | None]
Parameters = Mapping[str, Estimate | tuple[Estimate, ...]]
Truth = Mapping[str, float]

CORE = ("k", "T", "xi")


def errors(parameters: Parameters, truth: Truth) -> Columns:
    """``NAME_error`` and ``NAME_sigma`` of each physical parameter, relative to its true value."""
    found: Columns = {}
    for name, one in parameters.items():
        true = truth.get(name)
        if name == "bias" or not isinstance(one, Estimate) or not true:
            continue
        found[f"{name}_error"] = one.value / true - 1.0
        found[f"{name}_sigma"] = None if one.sigma is None else one.sigma / abs(true)
    return found


def bounds(recording: Recording, truth: Truth, effects: Sequence[str], noise_deg: float) -> Columns:
    """``NAME_bound``: the smallest relative standard deviation of an unbiased estimate.

    The Cramer-Rao limit of this command and these times, under white noise of ``noise_deg``, with
    ``effects`` in the model at their true values; bias and initial state are estimated as well
    (Ljung, System Identification, 1999, section 7.4). None where the command says nothing.
    """
    known = catalogue()
    names = [*CORE, "bias", *(n for n in truth if n.partition(".")[0] in effects)]
    units = {n: _unit(n, known) for n in names}
    actuator = Actuator({n: Estimate(truth[n], None, units[n]) for n in names}, tuple(effects))
    sigma = assess(actuator, [recording], noise_deg).sigma
    return {f"{n}_bound": s if math.isfinite(s) else None for n, s in sigma.items()}


def _unit(name: str, known: Mapping[str, object]) -> str:
    effect, dot, parameter = name.partition(".")
    if dot:
        return catalogue()[effect].parameter(parameter).unit
    return {"T": "s", "bias": "deg"}.get(name, "-")
