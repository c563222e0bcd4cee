"""Estimators: population searches and descents, behind one driver."""

from servosight.identify.search._estimator import Outcome as Outcome
from servosight.identify.search._estimator import Residuals as Residuals
from servosight.identify.search._estimator import drive as drive
from servosight.identify.search._estimator import half_squares as half_squares
from servosight.identify.search._levenberg_marquardt import GaussNewton as GaussNewton
from servosight.identify.search._memetic import Polished as Polished
from servosight.identify.search._population import OPERATORS as OPERATORS
from servosight.identify.search._population import Population as Population
from servosight.identify.search._population_state import Settings as Settings
