"""Grey video without loss, its time stamps in microseconds."""

from servosight.models.io.video._ffv1 import TICK as TICK
from servosight.models.io.video._ffv1 import Ffv1Encoder as Ffv1Encoder
from servosight.models.io.video._ffv1 import codec_context as codec_context
from servosight.models.io.video._matroska import TICK_S as TICK_S
from servosight.models.io.video._matroska import MatroskaWriter as MatroskaWriter
