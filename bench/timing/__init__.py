"""Command and video on one clock: the coded light read, stamps converted."""

from servosight.bench.timing._decode import ClockFit as ClockFit
from servosight.bench.timing._decode import LightPattern as LightPattern
from servosight.bench.timing._decode import decode as decode
from servosight.bench.timing._search import SeenLight as SeenLight
from servosight.bench.timing._search import block_means as block_means
from servosight.bench.timing._search import find_light as find_light
from servosight.bench.timing._stamps import MEANINGS as MEANINGS
from servosight.bench.timing._stamps import Meaning as Meaning
from servosight.bench.timing._stamps import even_stamps as even_stamps
from servosight.bench.timing._stamps import lost_between as lost_between
from servosight.bench.timing._stamps import mid_exposure as mid_exposure
