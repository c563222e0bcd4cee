"""From recordings to a fitted model."""

from servosight.identify.fit._fit import Fit as Fit
from servosight.identify.fit._fit import coordinate_scale as coordinate_scale
from servosight.identify.fit._fit import difference_quotient as difference_quotient
from servosight.identify.fit._fit import first_look as first_look
from servosight.identify.fit._fit import fit_effects as fit_effects
from servosight.identify.fit._fit import polish as polish
from servosight.identify.fit._fit import search_effects as search_effects
from servosight.identify.fit._fit import sketch_effects as sketch_effects
from servosight.identify.fit._identify import METHODS as METHODS
from servosight.identify.fit._identify import Identification as Identification
from servosight.identify.fit._identify import floor_deg as floor_deg
from servosight.identify.fit._identify import identify as identify
from servosight.identify.fit._identify import parameters_json as parameters_json
