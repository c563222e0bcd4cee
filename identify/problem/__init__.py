"""The fit as a search problem: parameters in, residuals out."""

from servosight.identify.problem._held import checked_held as checked_held
from servosight.identify.problem._jacobian import coordinate_scale as coordinate_scale
from servosight.identify.problem._jacobian import difference_quotient as difference_quotient
from servosight.identify.problem._noise import command_periods as command_periods
from servosight.identify.problem._noise import joint_noise_deg as joint_noise_deg
from servosight.identify.problem._noise import noise_deg as noise_deg
from servosight.identify.problem._noise import period_table as period_table
from servosight.identify.problem._noise import sample_noise_deg as sample_noise_deg
from servosight.identify.problem._problem import LOST_DEG as LOST_DEG
from servosight.identify.problem._problem import TOLERANCE_SHARE as TOLERANCE_SHARE
from servosight.identify.problem._problem import Coordinate as Coordinate
from servosight.identify.problem._problem import Problem as Problem
from servosight.identify.problem._problem import Work as Work
from servosight.identify.problem._projection import projected_out as projected_out
from servosight.identify.problem._read_errors import usable_views as usable_views
from servosight.identify.problem._read_limits import ReadErrorLimits as ReadErrorLimits
from servosight.identify.problem._score_directions import score_directions as score_directions
from servosight.identify.problem._starts import BaseModel as BaseModel
from servosight.identify.problem._starts import effect_guesses as effect_guesses
from servosight.identify.problem._starts import effect_starts as effect_starts
from servosight.identify.problem._starts import linear_start as linear_start
from servosight.identify.problem._starts import neutral_start as neutral_start
from servosight.identify.problem._starts import search_box as search_box
from servosight.identify.problem._thin import MOST_SAMPLES as MOST_SAMPLES
from servosight.identify.problem._thin import largest_share as largest_share
from servosight.identify.problem._thin import thinned as thinned
