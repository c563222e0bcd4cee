"""What a diagnosis returns, and the words for it."""

from servosight.diagnose.result._diagnosis import Candidate as Candidate
from servosight.diagnose.result._diagnosis import Diagnosis as Diagnosis
from servosight.diagnose.result._diagnosis import LadderStep as LadderStep
from servosight.diagnose.result._diagnosis import Verdict as Verdict
from servosight.diagnose.result._recording_use import RecordingUse as RecordingUse
from servosight.diagnose.result._recording_use import recording_uses as recording_uses
