"""Ways to measure the angle, one file each, in one registry.

A new method is a function ``(film, options, progress) -> Track`` in a file of its own, and one line
in ``METHOD_WORDS``.
"""

from servosight.tracking.methods._contract import Method as Method
from servosight.tracking.methods._even_turning import (
    beside_what_turns_evenly as beside_what_turns_evenly,
)
from servosight.tracking.methods._frames import (
    MovingPart as MovingPart,
)
from servosight.tracking.methods._frames import (
    TrackingSetup as TrackingSetup,
)
from servosight.tracking.methods._frames import (
    track_frames as track_frames,
)
from servosight.tracking.methods._registry import METHODS as METHODS
from servosight.tracking.methods._registry import method_of as method_of
