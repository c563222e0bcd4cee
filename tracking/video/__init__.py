"""Video in: frames, presentation times, stabilisation."""

from servosight.tracking.video._container import Header as Header
from servosight.tracking.video._container import check as check
from servosight.tracking.video._film import Film as Film
from servosight.tracking.video._film import open_film as open_film
from servosight.tracking.video._frame_table import read_frame_table as read_frame_table
from servosight.tracking.video._rate import even_times as even_times
from servosight.tracking.video._stabilisation import (
    LEAST_PX as LEAST_PX,
)
from servosight.tracking.video._stabilisation import (
    MOST_UNCLEAR as MOST_UNCLEAR,
)
from servosight.tracking.video._stabilisation import (
    CameraMotion as CameraMotion,
)
from servosight.tracking.video._stabilisation import (
    Stabiliser as Stabiliser,
)
from servosight.tracking.video._stabilisation import (
    roll_of as roll_of,
)
from servosight.tracking.video._video import (
    Frame as Frame,
)
from servosight.tracking.video._video import (
    calm_frames as calm_frames,
)
from servosight.tracking.video._video import (
    check_before_end as check_before_end,
)
from servosight.tracking.video._video import (
    frame_at as frame_at,
)
from servosight.tracking.video._video import (
    frames as frames,
)
from servosight.tracking.video._video import (
    read_frame as read_frame,
)
from servosight.tracking.video._video import (
    sample_frames as sample_frames,
)
from servosight.tracking.video._video import (
    stretches as stretches,
)
from servosight.tracking.video._window import Window as Window
from servosight.tracking.video._window import windowed as windowed
