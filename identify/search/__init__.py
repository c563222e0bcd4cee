"""Estimators: population searches and descents, behind one driver."""

from servosight.identify.search._estimator import NOT_FITTED as NOT_FITTED
from servosight.identify.search._estimator import Estimator as Estimator
from servosight.identify.search._estimator import Outcome as Outcome
from servosight.identify.search._estimator import Residuals as Residuals
from servosight.identify.search._estimator import SearchSpace as SearchSpace
from servosight.identify.search._estimator import StopReason as StopReason
from servosight.identify.search._estimator import drive as drive
from servosight.identify.search._estimator import half_squares as half_squares
from servosight.identify.search._estimators import ESTIMATORS as ESTIMATORS
from servosight.identify.search._levenberg_marquardt import DescentOptions as DescentOptions
from servosight.identify.search._levenberg_marquardt import LevenbergMarquardt as LevenbergMarquardt
from servosight.identify.search._memetic import MemeticOptions as MemeticOptions
from servosight.identify.search._memetic import MemeticSearch as MemeticSearch
from servosight.identify.search._population import OPERATORS as OPERATORS
from servosight.identify.search._population import Population as Population
from servosight.identify.search._population_state import PopulationOptions as PopulationOptions
