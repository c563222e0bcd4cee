"""Models that are not the plant equation: FMUs, fitted by their own parameters."""

from servosight.identify.foreign._fit import identify_fmu as identify_fmu
from servosight.identify.foreign._own import trusted as trusted
from servosight.identify.foreign._predict import predict_fmu as predict_fmu
from servosight.identify.foreign._result import FmuFit as FmuFit
from servosight.identify.foreign._runs import Interface as Interface
from servosight.identify.foreign._surroundings import LINEAR as LINEAR
from servosight.identify.foreign._surroundings import Surrounded as Surrounded
from servosight.identify.foreign._surroundings import Surroundings as Surroundings
from servosight.identify.foreign._surroundings import base_of as base_of
from servosight.identify.foreign._surroundings import check_outside as check_outside
from servosight.identify.foreign._surroundings import fmu_actuator as fmu_actuator
from servosight.identify.foreign._surroundings import is_around_fmu as is_around_fmu
from servosight.identify.foreign._surroundings import surrounded as surrounded
