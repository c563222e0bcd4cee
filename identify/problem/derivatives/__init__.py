"""Derivatives of the angles by the parameters, and what they say."""

from servosight.identify.problem.derivatives._jacobian import coordinate_scale as coordinate_scale
from servosight.identify.problem.derivatives._jacobian import (
    difference_quotient as difference_quotient,
)
from servosight.identify.problem.derivatives._projection import projected_out as projected_out
from servosight.identify.problem.derivatives._score_directions import (
    score_directions as score_directions,
)
