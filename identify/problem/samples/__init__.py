"""Which samples of a recording are scored, and how much each counts."""

from servosight.identify.problem.samples._read_errors import usable_views as usable_views
from servosight.identify.problem.samples._read_limits import ReadErrorLimits as ReadErrorLimits
from servosight.identify.problem.samples._thin import MOST_SAMPLES as MOST_SAMPLES
from servosight.identify.problem.samples._thin import largest_share as largest_share
from servosight.identify.problem.samples._thin import thinned as thinned
from servosight.identify.problem.samples._weights import TOLERANCE_SHARE as TOLERANCE_SHARE
from servosight.identify.problem.samples._weights import sample_weights as sample_weights
