"""Model against measurement: where it fails, what is missing, what adding it gains."""

from servosight.diagnose._add import add as add
from servosight.diagnose._compare import Comparison as Comparison
from servosight.diagnose._compare import compare as compare
from servosight.diagnose._diagnose import Candidate as Candidate
from servosight.diagnose._diagnose import Diagnosis as Diagnosis
from servosight.diagnose._diagnose import Step as Step
from servosight.diagnose._diagnose import diagnose as diagnose
