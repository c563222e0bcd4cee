"""Exposure and readout, found from the video itself."""

from servosight.tracking.calibration.shutter._estimate import LEAST as LEAST
from servosight.tracking.calibration.shutter._estimate import faster as faster
from servosight.tracking.calibration.shutter._estimate import found_shutters as found_shutters
from servosight.tracking.calibration.shutter._estimate import further_px as further_px
from servosight.tracking.calibration.shutter._estimate import further_speed as further_speed
from servosight.tracking.calibration.shutter._estimate import least_residual as least_residual
from servosight.tracking.calibration.shutter._estimate import unknown_shutters as unknown_shutters
from servosight.tracking.calibration.shutter._estimate import usual_speed as usual_speed
from servosight.tracking.calibration.shutter._find import find_shutter as find_shutter
from servosight.tracking.calibration.shutter._first_pass import first_pass as first_pass
from servosight.tracking.calibration.shutter._steady import steady_shear as steady_shear
