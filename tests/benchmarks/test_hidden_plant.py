"""The plain fixed steps agree with the plant equation, which knows nothing of them.

Bounds on the rms difference over 12 s, T = 20 ms: 0.001 deg where both solve the same equation
(leapfrog at 20 us errs by (dt / T)^2 / 24 of 20 deg, the rest is kinks met within a step); what
bristles and contacts differ in by design, elsewhere: a bristle bends by some reaches of 0.001 deg,
the part behind a gap loads its driver with 0.002 deg of friction, both passed on by the loop. Where
friction falls with speed, a surface that breaks loose later by that much jumps: twice the bound.
"""

from __future__ import annotations

import numpy as np
import pytest

from hidden.truth import OUTSIDE, equation, fixed_steps, known
from servosight.models.effects import catalogue
from servosight.models.excitation import standard
from servosight.scenarios.draws import DRAWS
from servosight.scenarios.settings import LinearServo

BOUND_DEG = {
    "coulomb_friction": 0.01,
    "load_dependent_friction": 0.01,
    "directional_friction": 0.01,
    "load_dependent_stribeck": 0.01,
    "stribeck_friction": 0.02,
    "backlash": 0.003,
}
COMMAND = standard(12.0, 20.0, seed=1)


@pytest.mark.parametrize("effect", [None, *(e for e in known("fixed steps") if e in DRAWS)])
def test_it_agrees_with_the_equation(effect: str | None) -> None:
    effects = {}
    servo = LinearServo(bias=1.0)
    if effect is not None:
        ranges = DRAWS[effect].parameters
        effects = {effect: {name: float(np.mean(span)) for name, span in ranges.items()}}
        assert set(ranges) == {parameter.name for parameter in catalogue()[effect].parameters}
    one = fixed_steps(servo, effects, COMMAND)
    other = equation(servo, effects, COMMAND)
    assert np.array_equal(one.time_s, other.time_s)
    difference = float(np.sqrt(np.mean((one.surface_deg - other.surface_deg) ** 2)))
    print(f"{effect}: {difference:.5f} deg rms")
    assert difference <= BOUND_DEG.get(effect or "", 1e-3)


@pytest.mark.parametrize("effect", OUTSIDE)
def test_what_is_outside_the_catalogue_shows(effect: str) -> None:
    """In the middle of its range it moves the surface by 0.1 deg rms at least."""
    values = {name: float(np.mean(span)) for name, span in OUTSIDE[effect].items()}
    plain = fixed_steps(LinearServo(), {}, COMMAND).surface_deg
    changed = fixed_steps(LinearServo(), {effect: values}, COMMAND).surface_deg
    assert np.all(np.isfinite(changed))
    assert np.sqrt(np.mean((changed - plain) ** 2)) > 0.1
