"""From the horn's angle to the surface's: the ratio over the angle, and play; no servo model."""

from servosight.identify.transmission._transmission import Transmission as Transmission
from servosight.identify.transmission._transmission import transmission as transmission
from servosight.identify.transmission._transmission import transmissions as transmissions
