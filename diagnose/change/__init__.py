"""Two servos, or one at two times: what differs, how surely, and what it means."""

from servosight.diagnose.change._change import STEP_DEG as STEP_DEG
from servosight.diagnose.change._change import ChangePolicy as ChangePolicy
from servosight.diagnose.change._change import ComparedServo as ComparedServo
from servosight.diagnose.change._change import ParameterChange as ParameterChange
from servosight.diagnose.change._change import ServoChange as ServoChange
from servosight.diagnose.change._change import change_between as change_between
from servosight.diagnose.change._change import limit_sigmas as limit_sigmas
from servosight.diagnose.change._recordings import change_in_recordings as change_in_recordings
from servosight.diagnose.change._recordings import refuse_fitting as refuse_fitting
