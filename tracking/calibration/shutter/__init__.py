"""Exposure and readout, found from the video itself."""

from servosight.tracking.calibration.shutter._find import find_shutter as find_shutter
from servosight.tracking.calibration.shutter._find import least_residual as least_residual
from servosight.tracking.calibration.shutter._find import share_by_width as share_by_width
from servosight.tracking.calibration.shutter._first_pass import first_pass as first_pass
