"""Models tried, compared and selected step by step."""

from servosight.diagnose.selection._confounding import Look as Look
from servosight.diagnose.selection._confounding import alternatives as alternatives
from servosight.diagnose.selection._confounding import confounded as confounded
from servosight.diagnose.selection._evidence import EXPLAINED as EXPLAINED
from servosight.diagnose.selection._evidence import MIN_EVIDENCE as MIN_EVIDENCE
from servosight.diagnose.selection._evidence import MIN_GAIN as MIN_GAIN
from servosight.diagnose.selection._evidence import TIE as TIE
from servosight.diagnose.selection._evidence import Bar as Bar
from servosight.diagnose.selection._evidence import criterion as criterion
from servosight.diagnose.selection._evidence import evidence as evidence
from servosight.diagnose.selection._ladder import Climb as Climb
from servosight.diagnose.selection._ladder import Climber as Climber
from servosight.diagnose.selection._ladder import Progress as Progress
from servosight.diagnose.selection._ladder import Rung as Rung
from servosight.diagnose.selection._ladder import silent as silent
from servosight.diagnose.selection._trial import BLOCK_S as BLOCK_S
from servosight.diagnose.selection._trial import HELD_OUT_EVERY as HELD_OUT_EVERY
from servosight.diagnose.selection._trial import Judged as Judged
from servosight.diagnose.selection._trial import Laboratory as Laboratory
from servosight.diagnose.selection._trial import Trial as Trial
from servosight.diagnose.selection._trial import predict_fixed as predict_fixed
