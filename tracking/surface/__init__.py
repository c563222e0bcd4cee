"""The moving part's picture, mask and outline."""

from servosight.tracking.surface._mask import surface_mask as surface_mask
from servosight.tracking.surface._outline import tightened as tightened
from servosight.tracking.surface._surface import Blurred as Blurred
from servosight.tracking.surface._surface import Surface as Surface
from servosight.tracking.surface._surface import learn as learn
from servosight.tracking.surface._surface import single as single
from servosight.tracking.surface._surface import spread as spread
