"""How a servo moves in a recording, and where that goes beyond the fitted data."""

from servosight.diagnose.motion._measured import MeasuredMotion as MeasuredMotion
from servosight.diagnose.motion._ranges import MARGIN as MARGIN
from servosight.diagnose.motion._ranges import RATIO as RATIO
from servosight.diagnose.motion._ranges import FittedRange as FittedRange
from servosight.diagnose.motion._ranges import MotionQuantity as MotionQuantity
from servosight.diagnose.motion._ranges import fitted_ranges as fitted_ranges
