"""From an address to a servo."""

from __future__ import annotations

from servosight.bench.host_clock import HOST, Clock
from servosight.bench.safety import Limits
from servosight.bench.servo._address import read_address
from servosight.bench.servo._supervised import SupervisedServo
from servosight.bench.servo.drivers import DRIVERS
from servosight.models.core import validated


def servo_kinds() -> tuple[str, ...]:
    """The kinds of servo that an address can name.

    >>> "dynamixel" in servo_kinds()
    True
    """
    return tuple(DRIVERS)


def open_servo(address: str, limits: Limits | None = None, clock: Clock = HOST) -> SupervisedServo:
    """Connect to the servo at ``address``, such as ``dynamixel:/dev/ttyUSB0?id=1&baud=57600``.

    Nothing moves. InputError for an address that is none, a port that cannot be opened, a servo
    that does not answer, or one that is not set up for ``limits`` (``Limits()`` by default).
    """
    where = read_address(address, DRIVERS)
    keys, make = DRIVERS[where.kind]
    limits = limits or Limits()
    driver = make(where.path, validated(where.keys, keys, address), clock)
    try:
        driver.connect(limits)
    except BaseException:
        driver.close()
        raise
    return SupervisedServo(driver, limits, clock)
