"""Footage as people film it: part and background as one model, from dense pictures alone."""

from servosight.tracking.composite._measure import PartMeter as PartMeter
from servosight.tracking.composite._measure import SteadySample as SteadySample
from servosight.tracking.composite._model import PoseFit as PoseFit
from servosight.tracking.composite._search import FoundPart as FoundPart
from servosight.tracking.composite._search import find_parts as find_parts
