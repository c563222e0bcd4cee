"""FMUs from elsewhere: checked, unpacked, and run in a process of their own."""

from servosight.models.fmu._archive import ArchiveLimits as ArchiveLimits
from servosight.models.fmu._archive import unpacked as unpacked
from servosight.models.fmu._fmu import Fmu as Fmu
from servosight.models.fmu._fmu import FmuLimits as FmuLimits
from servosight.models.fmu._fmu import FmuVariable as FmuVariable
from servosight.models.fmu._fmu import open_fmu as open_fmu
from servosight.models.fmu._model import FmuModel as FmuModel
from servosight.models.fmu._model import FmuRun as FmuRun
from servosight.models.fmu._pieces import Pieces as Pieces
