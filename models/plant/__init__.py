"""The one plant equation, compiled."""

from servosight.models.plant._plant import Plant as Plant
from servosight.models.plant._plant import Stimulus as Stimulus
