"""Lens, plane of motion, exposure and readout: from a calibration board or the video itself."""

from servosight.tracking.calibration._board import (
    Board as Board,
)
from servosight.tracking.calibration._board import (
    calibrate as calibrate,
)
from servosight.tracking.calibration._board import (
    read_views as read_views,
)
from servosight.tracking.calibration._board import (
    write_picture as write_picture,
)
from servosight.tracking.calibration._file import (
    camera_of as camera_of,
)
from servosight.tracking.calibration._file import (
    read_camera as read_camera,
)
from servosight.tracking.calibration._file import (
    write_camera as write_camera,
)
from servosight.tracking.calibration._view import (
    CameraView as CameraView,
)
from servosight.tracking.calibration._view import (
    rectifier as rectifier,
)
from servosight.tracking.calibration._view import (
    view_of as view_of,
)
