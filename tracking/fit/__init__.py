"""Gauss-Newton of the angle on the pixels of a picture, frame after frame."""

from servosight.tracking.fit._copied import lag as lag
from servosight.tracking.fit._copied import news as news
from servosight.tracking.fit._fit import Fit as Fit
from servosight.tracking.fit._fit import correlation as correlation
from servosight.tracking.fit._fit import gauss_newton as gauss_newton
from servosight.tracking.fit._fit import turn as turn
from servosight.tracking.fit._fit import turn_and_shift as turn_and_shift
from servosight.tracking.fit._follow import AngleEstimator as AngleEstimator
from servosight.tracking.fit._follow import Seen as Seen
from servosight.tracking.fit._follow import follow as follow
from servosight.tracking.fit._kernels import GATE as GATE
from servosight.tracking.fit._polar import Grid as Grid
from servosight.tracking.fit._polar import Pixels as Pixels
from servosight.tracking.fit._polar import Sample as Sample
from servosight.tracking.fit._polar import sample as sample
from servosight.tracking.fit._rotation_axis import PIVOT as PIVOT
from servosight.tracking.fit._rotation_axis import PLANE as PLANE
from servosight.tracking.fit._rotation_axis import PoseSensitivity as PoseSensitivity
from servosight.tracking.fit._rotation_axis import corrected_angles as corrected_angles
from servosight.tracking.fit._rotation_axis import rotation_axis as rotation_axis
