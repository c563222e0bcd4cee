"""Models of some effects, fitted to recordings and scored: what a selection decides between."""

from servosight.diagnose.selection.trials._kept import reached_deg as reached_deg
from servosight.diagnose.selection.trials._models import TRIAL_BUDGET as TRIAL_BUDGET
from servosight.diagnose.selection.trials._models import ModelSelection as ModelSelection
from servosight.diagnose.selection.trials._prediction import own_point as own_point
from servosight.diagnose.selection.trials._prediction import predict_fixed as predict_fixed
from servosight.diagnose.selection.trials._trial import Key as Key
from servosight.diagnose.selection.trials._trial import Trial as Trial
from servosight.diagnose.selection.trials._trial import is_far as is_far
from servosight.diagnose.selection.trials._trial import key_less as key_less
from servosight.diagnose.selection.trials._trial import key_of as key_of
