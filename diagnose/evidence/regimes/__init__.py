"""Where validation and test data go beyond the fitted ones, and what fitting them too gives."""

from servosight.diagnose.evidence.regimes._inclusion import include as include
from servosight.diagnose.evidence.regimes._regimes import WITHOUT_IT as WITHOUT_IT
from servosight.diagnose.evidence.regimes._regimes import Regime as Regime
from servosight.diagnose.evidence.regimes._regimes import RegimePolicy as RegimePolicy
from servosight.diagnose.evidence.regimes._regimes import regimes as regimes
