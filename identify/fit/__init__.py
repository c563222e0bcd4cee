"""From recordings to a fitted model."""

from servosight.identify.fit._effects import fit_effects as fit_effects
from servosight.identify.fit._effects import initial_changes as initial_changes
from servosight.identify.fit._effects import search_effects as search_effects
from servosight.identify.fit._effects import sketch_effects as sketch_effects
from servosight.identify.fit._identify import METHODS as METHODS
from servosight.identify.fit._identify import floor_deg as floor_deg
from servosight.identify.fit._identify import identify as identify
from servosight.identify.fit._identify import with_information as with_information
from servosight.identify.fit._own import OwnValues as OwnValues
from servosight.identify.fit._own import own_values as own_values
from servosight.identify.fit._own import predicted_angle as predicted_angle
from servosight.identify.fit._result import Fit as Fit
from servosight.identify.fit._result import parameter_table as parameter_table
from servosight.identify.fit._solution import Solution as Solution
from servosight.identify.fit._solution import polish as polish
