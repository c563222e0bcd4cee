"""Running many cells: what is on the disk counts, on one machine or many, from any interruption."""

from servosight.scenarios.sweeps.run._batch import BatchReport as BatchReport
from servosight.scenarios.sweeps.run._batch import Task as Task
from servosight.scenarios.sweeps.run._batch import run_batch as run_batch
from servosight.scenarios.sweeps.run._dask import dask_engine as dask_engine
from servosight.scenarios.sweeps.run._drive import Tally as Tally
from servosight.scenarios.sweeps.run._drive import drive as drive
from servosight.scenarios.sweeps.run._engine import Engine as Engine
from servosight.scenarios.sweeps.run._engine import InThisProcess as InThisProcess
from servosight.scenarios.sweeps.run._server import start_server as start_server
from servosight.scenarios.sweeps.run._store import Facts as Facts
from servosight.scenarios.sweeps.run._store import Store as Store
from servosight.scenarios.sweeps.run._watch import WatchLimits as WatchLimits
