"""Uncertainty of a fit."""

from servosight.identify.uncertainty._clock import clock_slope as clock_slope
from servosight.identify.uncertainty._correlation import by_recording as by_recording
from servosight.identify.uncertainty._correlation import weighted_normal as weighted_normal
from servosight.identify.uncertainty._matrix import Matrix as Matrix
from servosight.identify.uncertainty._matrix import determined_inverse as determined_inverse
from servosight.identify.uncertainty._matrix import inverse_within as inverse_within
from servosight.identify.uncertainty._sampling import misfit_share as misfit_share
from servosight.identify.uncertainty._sampling import sampling_covariance as sampling_covariance
from servosight.identify.uncertainty._uncertainty import Uncertainty as Uncertainty
