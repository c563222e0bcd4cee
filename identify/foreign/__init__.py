"""Models that are not the plant equation: FMUs, fitted by their own parameters."""

from servosight.identify.foreign._fit import identify_fmu as identify_fmu
from servosight.identify.foreign._own import fitted_own as fitted_own
from servosight.identify.foreign._own import trusted as trusted
from servosight.identify.foreign._result import FmuFit as FmuFit
