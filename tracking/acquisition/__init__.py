"""Finding the moving part and its pivot, a second part, and an indicator light in the pictures."""

from servosight.tracking.acquisition._acquire import acquire as acquire
from servosight.tracking.acquisition._hints import POINT as POINT
from servosight.tracking.acquisition._hints import check_hints as check_hints
from servosight.tracking.acquisition._hints import pointed_box as pointed_box
from servosight.tracking.acquisition._indicator import (
    CONFOUNDED as CONFOUNDED,
)
from servosight.tracking.acquisition._indicator import (
    IndicatorLight as IndicatorLight,
)
from servosight.tracking.acquisition._indicator import (
    find_light as find_light,
)
from servosight.tracking.acquisition._parts import same_view as same_view
from servosight.tracking.acquisition._parts import swept as swept
from servosight.tracking.acquisition._parts import without as without
