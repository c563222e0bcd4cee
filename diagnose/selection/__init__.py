"""Models tried, compared and selected step by step."""

from servosight.diagnose.selection._confounding import Resolution as Resolution
from servosight.diagnose.selection._confounding import alternatives as alternatives
from servosight.diagnose.selection._confounding import confounded as confounded
from servosight.diagnose.selection._criterion import AcceptanceCriterion as AcceptanceCriterion
from servosight.diagnose.selection._known import PriorKnowledge as PriorKnowledge
from servosight.diagnose.selection._own_latency import REMEDY as REMEDY
from servosight.diagnose.selection._own_latency import latencies_left as latencies_left
from servosight.diagnose.selection._own_latency import own_latencies as own_latencies
from servosight.diagnose.selection._policy import SelectionPolicy as SelectionPolicy
from servosight.diagnose.selection._score import Score as Score
from servosight.diagnose.selection._split import BLOCK_S as BLOCK_S
from servosight.diagnose.selection._split import Split as Split
from servosight.diagnose.selection._steps import SearchEffort as SearchEffort
from servosight.diagnose.selection._steps import Selected as Selected
from servosight.diagnose.selection._steps import Step as Step
from servosight.diagnose.selection._steps import new_in as new_in
from servosight.diagnose.selection._stepwise import StepwiseSelector as StepwiseSelector
from servosight.diagnose.selection._stretches import MOST_ROWS as MOST_ROWS
from servosight.diagnose.selection._stretches import Spans as Spans
from servosight.diagnose.selection._stretches import cut as cut
from servosight.diagnose.selection._stretches import stretches as stretches
from servosight.diagnose.selection.trials import ModelSelection as ModelSelection
from servosight.diagnose.selection.trials import Trial as Trial
from servosight.diagnose.selection.trials import own_point as own_point
from servosight.diagnose.selection.trials import predict_fixed as predict_fixed
