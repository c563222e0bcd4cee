"""Model against measurement: where it fails, what is missing, what adding it gains."""

from servosight.diagnose._add import add as add
from servosight.diagnose._compare import Comparison as Comparison
from servosight.diagnose._compare import compare as compare
from servosight.diagnose._compare import judge as judge
from servosight.diagnose._diagnose import diagnose as diagnose
from servosight.diagnose._predictions import law_predictions as law_predictions
from servosight.diagnose._predictions import predictions as predictions
from servosight.diagnose.evidence import with_detectable as with_detectable
from servosight.diagnose.fmu import compare_fmu as compare_fmu
from servosight.diagnose.fmu import diagnose_fmu as diagnose_fmu
from servosight.diagnose.residuals import listed as listed
from servosight.diagnose.residuals import phrased as phrased
from servosight.diagnose.result import Candidate as Candidate
from servosight.diagnose.result import Diagnosis as Diagnosis
from servosight.diagnose.result import LadderStep as LadderStep
from servosight.diagnose.result import RecordingUse as RecordingUse
from servosight.diagnose.result import Verdict as Verdict
from servosight.diagnose.result.wording import alternative_words as alternative_words
from servosight.diagnose.result.wording import named_model as named_model
from servosight.diagnose.selection import PriorKnowledge as PriorKnowledge
