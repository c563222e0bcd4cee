"""Surface, cover and background as layers, learnt from the video."""

from servosight.tracking.layers._fine import Layered as Layered
from servosight.tracking.layers._learn import layered_stage as layered_stage
