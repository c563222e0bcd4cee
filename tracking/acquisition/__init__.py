"""The moving part and its pivot, found from the motion."""

from servosight.tracking.acquisition._acquire import acquire as acquire
from servosight.tracking.acquisition._parts import same_view as same_view
from servosight.tracking.acquisition._parts import swept as swept
from servosight.tracking.acquisition._parts import without as without
from servosight.tracking.acquisition._search import search as search
