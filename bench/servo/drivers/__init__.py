"""The drivers, one file each. A new one is a file and a line in DRIVERS.

A driver comes with a frozen dataclass of the keys in its address, and is made from the port's path,
these settings and a clock.
"""

from collections.abc import Callable
from typing import Any

from servosight.bench.host_clock import Clock
from servosight.bench.servo._protocol import Driver
from servosight.bench.servo.drivers._board import Board, BoardSettings
from servosight.bench.servo.drivers._dynamixel import Dynamixel, DynamixelSettings
from servosight.bench.servo.drivers._feetech import Feetech, FeetechSettings
from servosight.bench.servo.drivers._maestro import Maestro, MaestroSettings

DRIVERS: dict[str, tuple[type[Any], Callable[[str, Any, Clock], Driver]]] = {
    "board": (BoardSettings, Board),
    "dynamixel": (DynamixelSettings, Dynamixel),
    "feetech": (FeetechSettings, Feetech),
    "maestro": (MaestroSettings, Maestro),
}
