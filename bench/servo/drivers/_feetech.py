"""Feetech STS and SMS series. The codec's docstring names the manuals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from servosight.bench.host_clock import Clock
from servosight.bench.safety import Limits
from servosight.bench.servo._port import Exchange, LineLamp, Port, ask
from servosight.bench.servo._protocol import Lamp, Reading, Sent, ServoFault
from servosight.bench.servo.codecs import feetech as codec
from servosight.models.core import InputError, within

STEPS = 4096
AMPERE = 6.5e-3
"""A per step of the present current (69)."""
_FIRST = codec.PRESENT_POSITION.address
_COUNT = codec.PRESENT_CURRENT.address + 2 - _FIRST


@dataclass(frozen=True, kw_only=True)
class FeetechSettings:
    """The keys of an address; ``light`` is on an output line of the adapter."""

    id: Annotated[int, within(0, 253, "as a whole number")] = 1
    baud: Annotated[int, within(38400, 1_000_000, "bit/s")] = 1_000_000
    light: Literal["none", "dtr", "rts"] = "none"


class Feetech:
    """A servo of the STS or SMS series in position mode.

    The protocol's checksum passes one damaged packet in some, and the servo has no watchdog. So the
    angle limits of the run are written into the servo itself, locked, which keeps them out of its
    EEPROM: they end with its power, and ``close`` puts the old ones back.
    """

    def __init__(self, path: str, settings: FeetechSettings, clock: Clock) -> None:
        """Open the port."""
        self.name = f"Feetech {settings.id} on {path}"
        self._id = settings.id
        self._port = Port(path, settings.baud, clock, self.name)
        self._old: tuple[int, int] | None = None
        lit = settings.light != "none"
        self.lamp: Lamp | None = LineLamp(self._port, settings.light) if lit else None

    def connect(self, limits: Limits) -> None:
        """Ping the servo, check its mode, and set its angle limits to the run's."""
        self._ask(codec.ping(self._id), 0)
        mode = self._get(codec.MODE)
        if mode != 0:
            raise InputError(
                f"{self.name}: operating mode is {mode}, expected 0 (position); set register 33 "
                f"with Feetech's debugging software"
            )
        low, high = self._get(codec.MIN_ANGLE_LIMIT), self._get(codec.MAX_ANGLE_LIMIT)
        if low == high == 0:
            low, high = 0, STEPS - 1  # no limit: several turns
        if not (low <= _steps(limits.low_deg) and _steps(limits.high_deg) <= high):
            raise InputError(
                f"{self.name}: its own limits are {_deg(low):.1f} to {_deg(high):.1f} deg, "
                f"expected to hold {limits.low_deg:g} to {limits.high_deg:g} deg; narrow the "
                f"limits of the run or set registers 9 and 11"
            )
        self._old = low, high
        self._set_limits(_steps(limits.low_deg), _steps(limits.high_deg))

    def enable(self, angle_deg: float) -> None:
        """Set the goal and switch the torque on."""
        self._ask(codec.write(self._id, codec.GOAL_POSITION, _steps(angle_deg)), 0)
        self._ask(codec.write(self._id, codec.TORQUE_ENABLE, 1), 0)

    def write(self, angle_deg: float) -> Sent:
        """Write the goal position (42); its speed and acceleration stay as they are set."""
        steps = _steps(angle_deg)
        question = codec.write(self._id, codec.GOAL_POSITION, steps)
        return Sent(self._ask(question, 0)[1].asked_s, _deg(steps))

    def read(self) -> Reading:
        """Position, voltage, temperature and current (56 to 70) in one packet."""
        data, exchange = self._ask(codec.read(self._id, _FIRST, _COUNT), _COUNT)
        position = codec.signed(codec.value_of(codec.PRESENT_POSITION, data, _FIRST))
        current = codec.signed(codec.value_of(codec.PRESENT_CURRENT, data, _FIRST))
        return Reading(
            time_s=exchange.middle_s,
            angle_deg=_deg(position),
            current_a=AMPERE * current,
            voltage_v=0.1 * codec.value_of(codec.PRESENT_VOLTAGE, data, _FIRST),
            temperature_c=float(codec.value_of(codec.PRESENT_TEMPERATURE, data, _FIRST)),
        )

    def disable(self) -> None:
        """Switch the torque off, also of a servo that reports a fault."""
        question = codec.write(self._id, codec.TORQUE_ENABLE, 0)
        ask(self._port, question, lambda received: self._status(received, 0, faults=False))

    def close(self) -> None:
        """Put the servo's own limits back, and let go of the port."""
        try:
            if self._old is not None:
                self._set_limits(*self._old)
        except InputError:
            pass  # the link is gone: the limits end with the servo's power
        finally:
            self._port.close()

    def _set_limits(self, low: int, high: int) -> None:
        self._ask(codec.write(self._id, codec.LOCK, 1), 0)
        self._ask(codec.write(self._id, codec.MIN_ANGLE_LIMIT, low, high), 0)

    def _get(self, register: codec.Register) -> int:
        data, _ = self._ask(codec.read(self._id, *register), register.size)
        return codec.value_of(register, data, register.address)

    def _ask(self, question: bytes, size: int) -> tuple[bytes, Exchange]:
        return ask(self._port, question, lambda received: self._status(received, size))

    def _status(self, received: bytes, size: int, faults: bool = True) -> bytes | None:
        """The parameters of this servo's answer; None as long as there is none of that size."""
        for packet in codec.split(received)[0]:
            if packet.id != self._id or len(packet.parameters) != size:
                continue
            named = [what for bit, what in codec.ERRORS.items() if packet.code >> bit & 1]
            if faults and packet.code:
                raise ServoFault(
                    f"{self.name}: the servo reports {' and '.join(named) or hex(packet.code)}; "
                    f"remove the cause and switch its power off and on"
                )
            return packet.parameters
        return None


def _steps(angle_deg: float) -> int:
    return round(STEPS / 2 + angle_deg * STEPS / 360.0)


def _deg(steps: int) -> float:
    return (steps - STEPS / 2) * 360.0 / STEPS
