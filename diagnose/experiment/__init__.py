"""The next experiment."""

from servosight.diagnose.experiment._experiment import propose as propose
from servosight.diagnose.experiment._experiment import recorded_limits as recorded_limits
from servosight.diagnose.experiment._proposal import DECIDES as DECIDES
from servosight.diagnose.experiment._proposal import Proposal as Proposal
from servosight.diagnose.experiment._proposal import Separation as Separation
