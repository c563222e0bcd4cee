"""From recordings to the selected model, its steps and its rivals."""

from servosight.diagnose.outcome._data import DiagnosisData as DiagnosisData
from servosight.diagnose.outcome._data import diagnosis_data as diagnosis_data
from servosight.diagnose.outcome._outcome import Outcome as Outcome
from servosight.diagnose.outcome._outcome import select as select
from servosight.diagnose.outcome._outcome import verdict_of as verdict_of
from servosight.diagnose.outcome._outcome import with_ladder as with_ladder
from servosight.diagnose.outcome._rivalry import Rivalry as Rivalry
from servosight.diagnose.outcome._rivalry import accepted as accepted
from servosight.diagnose.outcome._rivalry import rivalry as rivalry
