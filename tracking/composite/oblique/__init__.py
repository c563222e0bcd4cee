"""A part seen from off its axis of rotation: by how much, and what that does to its angle."""

from servosight.tracking.composite.oblique._correction import ObliqueView as ObliqueView
from servosight.tracking.composite.oblique._correction import SampledPart as SampledPart
from servosight.tracking.composite.oblique._correction import oblique_view as oblique_view
from servosight.tracking.composite.oblique._poses import paces_rad as paces_rad
