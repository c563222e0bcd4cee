"""Sweeps: one scenario in many variations, run on one machine or many, and what they teach.

What plans and runs them is loaded when it is used; to read results needs no simulation.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from servosight.scenarios.sweeps._rows import results as results
from servosight.scenarios.sweeps._rows import with_facts as with_facts
from servosight.scenarios.sweeps.answers import SHIPPED as SHIPPED
from servosight.scenarios.sweeps.answers import Found as Found
from servosight.scenarios.sweeps.answers import Summary as Summary
from servosight.scenarios.sweeps.answers import advise as advise
from servosight.scenarios.sweeps.answers import saved_answers as saved_answers
from servosight.scenarios.sweeps.answers import summary as summary
from servosight.scenarios.sweeps.answers import value_text as value_text
from servosight.scenarios.sweeps.run import Tally as Tally

if TYPE_CHECKING:
    from servosight.scenarios.sweeps._run import run_sweep as run_sweep
    from servosight.scenarios.sweeps.plan import READY as READY
    from servosight.scenarios.sweeps.plan import Sweep as Sweep
    from servosight.scenarios.sweeps.plan import read_sweep as read_sweep

_LATER = {"run_sweep": "_run", "READY": "plan", "Sweep": "plan", "read_sweep": "plan"}


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_LATER[name]}"), name)
