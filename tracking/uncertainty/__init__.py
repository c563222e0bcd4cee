"""From the fits of all frames to angles and their sigma."""

from servosight.tracking.uncertainty._evaluate import (
    Angles as Angles,
)
from servosight.tracking.uncertainty._evaluate import (
    Measured as Measured,
)
from servosight.tracking.uncertainty._evaluate import (
    evaluate as evaluate,
)
from servosight.tracking.uncertainty._sigma import gaps as gaps
