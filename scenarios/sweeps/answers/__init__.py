"""What the rows of a sweep say: tables by axis, detection by size, and what to buy."""

from servosight.scenarios.sweeps.answers._summary import Summary as Summary
from servosight.scenarios.sweeps.answers._summary import summary as summary
