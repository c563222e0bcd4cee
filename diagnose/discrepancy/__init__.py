"""A law for what no catalogued effect accounts for."""

from servosight.diagnose.discrepancy._law import Law as Law
from servosight.diagnose.discrepancy._law import Missing as Missing
from servosight.diagnose.discrepancy._law import find_law as find_law
from servosight.diagnose.discrepancy._law import missing_torque as missing_torque
