"""Background and part as one model of a picture."""

from servosight.tracking.composite.model._model import CompositeModel as CompositeModel
from servosight.tracking.composite.model._model import PoseFit as PoseFit
from servosight.tracking.composite.model._model import pivot_step as pivot_step
from servosight.tracking.composite.model._raster import PartRaster as PartRaster
from servosight.tracking.composite.model._raster import cover_in as cover_in
from servosight.tracking.composite.model._raster import covers_in as covers_in
