"""The information of a command about parameters, and commands that give more."""

from servosight.identify.design._information import Information as Information
from servosight.identify.design._information import InformationSummary as InformationSummary
from servosight.identify.design._optimal import optimal as optimal
from servosight.identify.design._predicted_experiment import assess as assess
from servosight.identify.design._predicted_experiment import better_command as better_command
from servosight.identify.design._predicted_experiment import (
    predicted_experiment as predicted_experiment,
)
