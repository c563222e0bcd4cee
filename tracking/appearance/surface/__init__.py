"""The moving part's picture, mask and outline, and its angle from its interior."""

from servosight.tracking.appearance.surface._estimator import (
    SurfaceEstimator as SurfaceEstimator,
)
from servosight.tracking.appearance.surface._estimator import (
    likely as likely,
)
from servosight.tracking.appearance.surface._mask import surface_mask as surface_mask
from servosight.tracking.appearance.surface._outline import tightened as tightened
from servosight.tracking.appearance.surface._search import search as search
from servosight.tracking.appearance.surface._surface import (
    BlurredSurface as BlurredSurface,
)
from servosight.tracking.appearance.surface._surface import (
    Surface as Surface,
)
from servosight.tracking.appearance.surface._surface import (
    learn as learn,
)
from servosight.tracking.appearance.surface._surface import (
    single as single,
)
from servosight.tracking.appearance.surface._surface import (
    spread as spread,
)
