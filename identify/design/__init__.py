"""What a command tells about parameters, and commands that tell more."""

from servosight.identify.design._optimal import optimal as optimal
from servosight.identify.design._predicted_experiment import assess as assess
from servosight.identify.design._predicted_experiment import better_command as better_command
from servosight.identify.design._predicted_experiment import rehearsal as rehearsal
