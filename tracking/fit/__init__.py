"""Gauss-Newton of the angle on the pixels of a picture, frame after frame."""

from servosight.tracking.fit._copied import lag as lag
from servosight.tracking.fit._copied import stale as stale
from servosight.tracking.fit._fit import AngleFit as AngleFit
from servosight.tracking.fit._fit import correlation as correlation
from servosight.tracking.fit._fit import gauss_newton as gauss_newton
from servosight.tracking.fit._fit import turn as turn
from servosight.tracking.fit._fit import turn_and_shift as turn_and_shift
from servosight.tracking.fit._follow import AngleEstimator as AngleEstimator
from servosight.tracking.fit._follow import TrackedFrame as TrackedFrame
from servosight.tracking.fit._follow import follow as follow
from servosight.tracking.fit._kernels import GATE as GATE
from servosight.tracking.fit._polar import NONE_STALE as NONE_STALE
from servosight.tracking.fit._polar import Pixels as Pixels
from servosight.tracking.fit._polar import PolarGrid as PolarGrid
from servosight.tracking.fit._polar import Sample as Sample
from servosight.tracking.fit._polar import spacing as spacing
from servosight.tracking.fit._rings import RingPixels as RingPixels
from servosight.tracking.fit._rings import runs_of as runs_of
from servosight.tracking.fit._rotation_axis import PIVOT as PIVOT
from servosight.tracking.fit._rotation_axis import PLANE as PLANE
from servosight.tracking.fit._rotation_axis import PoseSensitivity as PoseSensitivity
from servosight.tracking.fit._rotation_axis import corrected_angles as corrected_angles
from servosight.tracking.fit._rotation_axis import rotation_axis as rotation_axis
from servosight.tracking.fit._rotation_axis import turned_errors as turned_errors
from servosight.tracking.fit._starts import StartCheck as StartCheck
