"""Footage as people film it: part and background as one model, from dense pictures alone."""

from servosight.tracking.composite._continuity import longest_sure as longest_sure
from servosight.tracking.composite._exposure import find_exposure as find_exposure
from servosight.tracking.composite._hint import Hint as Hint
from servosight.tracking.composite._measure import PartMeter as PartMeter
from servosight.tracking.composite._measure import outline_of as outline_of
from servosight.tracking.composite._rigid_check import sides_apart_rad as sides_apart_rad
from servosight.tracking.composite._settled import settled_part as settled_part
from servosight.tracking.composite._stabilised import StabilisedSample as StabilisedSample
from servosight.tracking.composite._stabilised import evenly as evenly
from servosight.tracking.composite._trust import TRUST as TRUST
from servosight.tracking.composite._trust import distrust as distrust
from servosight.tracking.composite._trust import rough_enough as rough_enough
from servosight.tracking.composite._trust import rough_note as rough_note
from servosight.tracking.composite._trust import uncertain as uncertain
from servosight.tracking.composite.model import PoseFit as PoseFit
from servosight.tracking.composite.oblique import ObliqueView as ObliqueView
from servosight.tracking.composite.oblique import SampledPart as SampledPart
from servosight.tracking.composite.oblique import oblique_view as oblique_view
from servosight.tracking.composite.oblique import paces_rad as paces_rad
from servosight.tracking.composite.parts import entering as entering
from servosight.tracking.composite.parts import without_entering as without_entering
from servosight.tracking.composite.search import CLICKED as CLICKED
from servosight.tracking.composite.search import FoundPart as FoundPart
from servosight.tracking.composite.search import find_parts as find_parts
from servosight.tracking.composite.search import found_about as found_about
from servosight.tracking.composite.search import parts_otherwise as parts_otherwise
