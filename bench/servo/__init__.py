"""Servos: one small protocol, and the drivers behind it."""

from servosight.bench.servo._protocol import LinkLost as LinkLost
from servosight.bench.servo._protocol import Reading as Reading
from servosight.bench.servo._protocol import Servo as Servo
