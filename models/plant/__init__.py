"""The one plant equation, compiled."""

from servosight.models.plant._describing import describing_function as describing_function
from servosight.models.plant._describing import integral_s as integral_s
from servosight.models.plant._difference import TRANSFORMS as TRANSFORMS
from servosight.models.plant._difference import Difference as Difference
from servosight.models.plant._difference import Linear as Linear
from servosight.models.plant._difference import to_difference as to_difference
from servosight.models.plant._limit_cycles import LimitCycle as LimitCycle
from servosight.models.plant._limit_cycles import limit_cycles as limit_cycles
from servosight.models.plant._loop_filter import loop_filter as loop_filter
from servosight.models.plant._metrics import StepMetrics as StepMetrics
from servosight.models.plant._metrics import bandwidth_hz as bandwidth_hz
from servosight.models.plant._metrics import natural_frequency_hz as natural_frequency_hz
from servosight.models.plant._metrics import resonance_db as resonance_db
from servosight.models.plant._metrics import step_metrics as step_metrics
from servosight.models.plant._plant import Plant as Plant
from servosight.models.plant._plant import Stimulus as Stimulus
from servosight.models.plant._predict import command_recording as command_recording
from servosight.models.plant._predict import predict as predict
from servosight.models.plant._predict import predict_from_rest as predict_from_rest
from servosight.models.plant._predict import to_the_end as to_the_end
from servosight.models.plant.kernel import Layout as Layout
from servosight.models.plant.kernel import kernel_source as kernel_source
