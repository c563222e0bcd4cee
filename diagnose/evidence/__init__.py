"""What a diagnosis rests on: the regimes of the data, and what they can and cannot show."""

from servosight.diagnose.evidence._detectable import detectable as detectable
from servosight.diagnose.evidence._detectable import with_detectable as with_detectable
from servosight.diagnose.evidence._equivalents import equivalents as equivalents
from servosight.diagnose.evidence._equivalents import interchangeable as interchangeable
from servosight.diagnose.evidence._equivalents import special_case as special_case
from servosight.diagnose.evidence._evidence import Evidence as Evidence
from servosight.diagnose.evidence._evidence import gather as gather
from servosight.diagnose.evidence._partial import RECORD_AGAIN as RECORD_AGAIN
from servosight.diagnose.evidence._partial import Unexplained as Unexplained
from servosight.diagnose.evidence._partial import partial as partial
from servosight.diagnose.evidence._partial import taken as taken
from servosight.diagnose.evidence._repeats import Repeated as Repeated
from servosight.diagnose.evidence._repeats import repeated as repeated
from servosight.diagnose.evidence._repeats import run_floor as run_floor
from servosight.diagnose.evidence._repeats import run_scatter_deg as run_scatter_deg
from servosight.diagnose.evidence.regimes import Regime as Regime
from servosight.diagnose.evidence.regimes import RegimePolicy as RegimePolicy
from servosight.diagnose.evidence.regimes import regimes as regimes
from servosight.diagnose.evidence.stability import Stability as Stability
from servosight.diagnose.evidence.stability import firm as firm
from servosight.diagnose.evidence.stability import resamples as resamples
from servosight.diagnose.evidence.stability import stability as stability
from servosight.diagnose.evidence.stability import stable_steps as stable_steps
from servosight.diagnose.evidence.stability import undetermined as undetermined
from servosight.diagnose.evidence.stability import unmeasured as unmeasured
from servosight.diagnose.evidence.stability import winner as winner
