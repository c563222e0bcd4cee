"""What a command may not exceed, and how a servo is brought to its start and to rest."""

from servosight.bench.safety._limits import LIMIT_OPTIONS as LIMIT_OPTIONS
from servosight.bench.safety._limits import Limits as Limits
from servosight.bench.safety._limits import check_command as check_command
from servosight.bench.safety._ramp import ramp as ramp
from servosight.bench.safety._release import Releasable as Releasable
from servosight.bench.safety._release import released as released
