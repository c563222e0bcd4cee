"""A law for what no catalogued effect accounts for."""

from servosight.diagnose.discrepancy._law import MIN_CLOSED as MIN_CLOSED
from servosight.diagnose.discrepancy._law import Found as Found
from servosight.diagnose.discrepancy._law import find_law as find_law
from servosight.diagnose.discrepancy._law import share_closed as share_closed
from servosight.diagnose.discrepancy._result import Law as Law
from servosight.diagnose.discrepancy._result import LawTerm as LawTerm
from servosight.diagnose.discrepancy._result import MissingTorque as MissingTorque
from servosight.diagnose.discrepancy._result import law_effects as law_effects
from servosight.diagnose.discrepancy._result import reported_law as reported_law
