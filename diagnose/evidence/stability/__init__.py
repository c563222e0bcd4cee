"""Whether the names hold: without parts of the data, and against their parameters' uncertainty."""

from servosight.diagnose.evidence.stability._determined import motionless as motionless
from servosight.diagnose.evidence.stability._determined import not_shown_beyond as not_shown_beyond
from servosight.diagnose.evidence.stability._determined import undetermined as undetermined
from servosight.diagnose.evidence.stability._determined import unmeasured as unmeasured
from servosight.diagnose.evidence.stability._resamples import resamples as resamples
from servosight.diagnose.evidence.stability._stability import LEAST as LEAST
from servosight.diagnose.evidence.stability._stability import Stability as Stability
from servosight.diagnose.evidence.stability._stability import firm as firm
from servosight.diagnose.evidence.stability._stability import stability as stability
from servosight.diagnose.evidence.stability._stability import stable_steps as stable_steps
from servosight.diagnose.evidence.stability._stability import winner as winner
