"""Search among whole sets of effects, where single steps end far from the floor."""

from servosight.diagnose.selection.search._backward import BackwardSearch as BackwardSearch
from servosight.diagnose.selection.search._beam import BeamSearch as BeamSearch
from servosight.diagnose.selection.search._further import with_further as with_further
from servosight.diagnose.selection.search._preferred import (
    fewest_assumptions as fewest_assumptions,
)
from servosight.diagnose.selection.search._preferred import simplified as simplified
from servosight.diagnose.selection.search._preferred import with_own_gain as with_own_gain
from servosight.diagnose.selection.search._preferred import with_weight as with_weight
from servosight.diagnose.selection.search._progress import BestSoFar as BestSoFar
from servosight.diagnose.selection.search._special import to_special_cases as to_special_cases
from servosight.diagnose.selection.search._visited import Visited as Visited
from servosight.diagnose.selection.search._wide import completed as completed
from servosight.diagnose.selection.search._wide import fitted_jointly as fitted_jointly
from servosight.diagnose.selection.search._wide import ordinary_at_once as ordinary_at_once
from servosight.diagnose.selection.search._wide import searched_widely as searched_widely
