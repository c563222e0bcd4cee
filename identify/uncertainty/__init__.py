"""Uncertainty of a fit."""

from servosight.identify.uncertainty._matrix import Matrix as Matrix
from servosight.identify.uncertainty._uncertainty import Uncertainty as Uncertainty
