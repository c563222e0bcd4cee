"""Terms that such a law may be made of."""

from servosight.diagnose.discrepancy.basis._drive import DRIVES as DRIVES
from servosight.diagnose.discrepancy.basis._friction import FRICTIONS as FRICTIONS
from servosight.diagnose.discrepancy.basis._load import LOADS as LOADS
from servosight.diagnose.discrepancy.basis._term import BasisMotion as BasisMotion
from servosight.diagnose.discrepancy.basis._term import BasisTerm as BasisTerm
from servosight.diagnose.discrepancy.basis._term import Extent as Extent
from servosight.diagnose.discrepancy.basis._term import Point as Point
from servosight.diagnose.discrepancy.basis._time import TIMES as TIMES
