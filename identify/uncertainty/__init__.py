"""Uncertainty of a fit."""

from servosight.identify.uncertainty._uncertainty import estimates as estimates
from servosight.identify.uncertainty._uncertainty import own_estimates as own_estimates
