"""Sweeps: one scenario in many variations, run on one machine or many, and what they teach."""

from servosight.scenarios.sweeps._run import results as results
from servosight.scenarios.sweeps._run import run_sweep as run_sweep
from servosight.scenarios.sweeps._run import with_facts as with_facts
from servosight.scenarios.sweeps.answers import Found as Found
from servosight.scenarios.sweeps.answers import Summary as Summary
from servosight.scenarios.sweeps.answers import summary as summary
from servosight.scenarios.sweeps.answers import value_text as value_text
from servosight.scenarios.sweeps.plan import READY as READY
from servosight.scenarios.sweeps.plan import Sweep as Sweep
from servosight.scenarios.sweeps.plan import read_sweep as read_sweep
from servosight.scenarios.sweeps.run import Tally as Tally
