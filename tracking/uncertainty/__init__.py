"""From the fits of all frames to angles and their sigma."""

from servosight.tracking.uncertainty._delay import by_delay as by_delay
from servosight.tracking.uncertainty._evaluate import (
    EvaluatedAngles as EvaluatedAngles,
)
from servosight.tracking.uncertainty._evaluate import (
    FrameMeasurements as FrameMeasurements,
)
from servosight.tracking.uncertainty._evaluate import (
    evaluate as evaluate,
)
from servosight.tracking.uncertainty._repeats import lag_of_repeats as lag_of_repeats
from servosight.tracking.uncertainty._scatter import even_scatter as even_scatter
from servosight.tracking.uncertainty._sigma import gaps as gaps
