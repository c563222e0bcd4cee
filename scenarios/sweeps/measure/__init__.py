"""What a cell does: it makes a recording, identifies, diagnoses, and scores against the truth."""

from servosight.scenarios.sweeps.measure._cell import CellWork as CellWork
from servosight.scenarios.sweeps.measure._cell import measure as measure
from servosight.scenarios.sweeps.measure._warm import LOADED as LOADED
from servosight.scenarios.sweeps.measure._warm import POOLS as POOLS
from servosight.scenarios.sweeps.measure._warm import warm as warm
