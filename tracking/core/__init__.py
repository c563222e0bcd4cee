"""Types and small operations that all stages share."""

from servosight.tracking.core._exposure import (
    STILL as STILL,
)
from servosight.tracking.core._exposure import (
    Exposure as Exposure,
)
from servosight.tracking.core._exposure import (
    Shutter as Shutter,
)
from servosight.tracking.core._exposure import (
    Shutters as Shutters,
)
from servosight.tracking.core._exposure import (
    local_motion as local_motion,
)
from servosight.tracking.core._features import Index as Index
from servosight.tracking.core._features import matched as matched
from servosight.tracking.core._options import (
    Family as Family,
)
from servosight.tracking.core._options import (
    Progress as Progress,
)
from servosight.tracking.core._options import (
    TrackOptions as TrackOptions,
)
from servosight.tracking.core._plane import (
    PICTURE as PICTURE,
)
from servosight.tracking.core._plane import (
    CameraGeometry as CameraGeometry,
)
from servosight.tracking.core._plane import (
    Lens as Lens,
)
from servosight.tracking.core._plane import (
    MotionPlane as MotionPlane,
)
from servosight.tracking.core._plane import (
    inverse as inverse,
)
from servosight.tracking.core._plane import (
    like_picture as like_picture,
)
from servosight.tracking.core._plane import (
    mapped as mapped,
)
from servosight.tracking.core._rotation import turned as turned
from servosight.tracking.core._rotation import turning as turning
from servosight.tracking.core._shared import one_sigma as one_sigma
from servosight.tracking.core._shared import principal as principal
from servosight.tracking.core._spline import (
    slopes as slopes,
)
from servosight.tracking.core._spline import (
    smeared as smeared,
)
from servosight.tracking.core._spline import (
    weights as weights,
)
from servosight.tracking.core._track import (
    Box as Box,
)
from servosight.tracking.core._track import (
    Flag as Flag,
)
from servosight.tracking.core._track import (
    Track as Track,
)
from servosight.tracking.core._track import (
    outline_at as outline_at,
)
