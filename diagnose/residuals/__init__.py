"""What the error of a model shows, and where."""

from servosight.diagnose.residuals._events import swings as swings
from servosight.diagnose.residuals._events import turns as turns
from servosight.diagnose.residuals._findings import CHANCE as CHANCE
from servosight.diagnose.residuals._findings import Finding as Finding
from servosight.diagnose.residuals._findings import findings as findings
from servosight.diagnose.residuals._findings import lead as lead
from servosight.diagnose.residuals._frequency import Response as Response
from servosight.diagnose.residuals._frequency import response as response
from servosight.diagnose.residuals._profiles import Quantity as Quantity
from servosight.diagnose.residuals._profiles import profile as profile
from servosight.diagnose.residuals._samples import Samples as Samples
from servosight.diagnose.residuals._samples import all_samples as all_samples
from servosight.diagnose.residuals._samples import held_out_samples as held_out_samples
from servosight.diagnose.residuals._tests import LEVELS as LEVELS
from servosight.diagnose.residuals._tests import Correlation as Correlation
from servosight.diagnose.residuals._tests import independence as independence
from servosight.diagnose.residuals._tests import linear_share as linear_share
from servosight.diagnose.residuals._tests import quantile as quantile
from servosight.diagnose.residuals._tests import whiteness as whiteness
from servosight.diagnose.residuals._where import Window as Window
from servosight.diagnose.residuals._where import shares as shares
from servosight.diagnose.residuals._where import worst_windows as worst_windows
