"""Stand-ins on the wire: servos on pseudo-terminals, byte by byte, and a camera's stream.

A ``Wire`` is the terminal with a ``StandIn`` at its far end and ``Faults`` in between. Under a
``VirtualClock`` time passes only while somebody waits; ``serving`` serves a wire in real time.
What moves is a ``Plant``, which the caller hands in.
"""

from servosight.bench.wire._audience import Audience as Audience
from servosight.bench.wire._board import BoardStandIn as BoardStandIn
from servosight.bench.wire._clock import VirtualClock as VirtualClock
from servosight.bench.wire._clock import serving as serving
from servosight.bench.wire._dynamixel import DynamixelStandIn as DynamixelStandIn
from servosight.bench.wire._feetech import FeetechStandIn as FeetechStandIn
from servosight.bench.wire._maestro import MaestroStandIn as MaestroStandIn
from servosight.bench.wire._mjpeg import MjpegServer as MjpegServer
from servosight.bench.wire._mjpeg import ServedFrame as ServedFrame
from servosight.bench.wire._plant import Plant as Plant
from servosight.bench.wire._standin import StandIn as StandIn
from servosight.bench.wire._wire import Faults as Faults
from servosight.bench.wire._wire import Wire as Wire
