"""What goes over the wire, as pure functions on bytes; drivers and stand-ins use the same.

Each module has a function for every instruction, and ``split(received) -> (packets, rest)``, which
finds whole packets in what has been received, skips damaged bytes, and returns what may still be
the beginning of a packet.
"""

from servosight.bench.servo.codecs import board as board
from servosight.bench.servo.codecs import dynamixel as dynamixel
from servosight.bench.servo.codecs import feetech as feetech
from servosight.bench.servo.codecs import maestro as maestro
