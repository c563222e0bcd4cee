"""A recording's noise, from its numbers alone."""

from servosight.identify.problem.noise._noise import command_periods as command_periods
from servosight.identify.problem.noise._noise import joint_noise_deg as joint_noise_deg
from servosight.identify.problem.noise._noise import noise_deg as noise_deg
from servosight.identify.problem.noise._noise import period_table as period_table
from servosight.identify.problem.noise._noise import resolution_deg as resolution_deg
from servosight.identify.problem.noise._noise import sample_noise_deg as sample_noise_deg
from servosight.identify.problem.noise._standstill import standstill_errors as standstill_errors
