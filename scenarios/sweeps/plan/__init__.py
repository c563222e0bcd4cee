"""What a sweep is: its file, its axes, its cells and their seeds."""

from servosight.scenarios.sweeps.plan._cells import Cell as Cell
from servosight.scenarios.sweeps.plan._cells import cell_seed as cell_seed
from servosight.scenarios.sweeps.plan._cells import cells as cells
from servosight.scenarios.sweeps.plan._scenario import hidden_names as hidden_names
from servosight.scenarios.sweeps.plan._scenario import scenario_of as scenario_of
from servosight.scenarios.sweeps.plan._sweep import READY as READY
from servosight.scenarios.sweeps.plan._sweep import CellLimits as CellLimits
from servosight.scenarios.sweeps.plan._sweep import Sweep as Sweep
from servosight.scenarios.sweeps.plan._sweep import read_sweep as read_sweep
from servosight.scenarios.sweeps.plan._user import user_function as user_function
from servosight.scenarios.sweeps.plan._versions import content_digest as content_digest
from servosight.scenarios.sweeps.plan._versions import versions as versions
