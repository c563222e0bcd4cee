"""Servos: one small protocol, and the drivers behind it.

``open_servo`` connects, ``bench.safety.released`` arms and releases, ``play`` moves.
"""

from servosight.bench.servo._play import CommandLog as CommandLog
from servosight.bench.servo._play import play as play
from servosight.bench.servo._protocol import Driver as Driver
from servosight.bench.servo._protocol import Lamp as Lamp
from servosight.bench.servo._protocol import LinkLost as LinkLost
from servosight.bench.servo._protocol import Reading as Reading
from servosight.bench.servo._protocol import Servo as Servo
from servosight.bench.servo._protocol import ServoFault as ServoFault
from servosight.bench.servo._protocol import StoredPlayback as StoredPlayback
from servosight.bench.servo._registry import open_servo as open_servo
from servosight.bench.servo._registry import servo_kinds as servo_kinds
from servosight.bench.servo._supervised import SupervisedServo as SupervisedServo
