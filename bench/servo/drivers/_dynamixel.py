"""Dynamixel X series, protocol 2.0. The codec's docstring names the manuals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from servosight.bench.host_clock import Clock
from servosight.bench.safety import Limits
from servosight.bench.servo._port import LINE_SIGMA_S, TRIES, Exchange, LineLamp, Port, ask
from servosight.bench.servo._protocol import Lamp, Reading, Sent, ServoFault, WatchdogTripped
from servosight.bench.servo.codecs import dynamixel as codec
from servosight.models.core import InputError, within

STEPS = 4096
"""Steps of a turn; 2048 is the middle."""
POSITION_MODES = (3, 4, 5)
"""Operating mode: position, extended position, current-based position."""
WATCHDOG = 25
"""Bus watchdog in units of 20 ms: the servo stops by itself after 0.5 s without a packet."""
_FIRST = codec.PRESENT_CURRENT.address
_COUNT = codec.PRESENT_TEMPERATURE.address + 1 - _FIRST

MODELS = {
    1020: ("XM430-W350", 2.69e-3),
    1030: ("XM430-W210", 2.69e-3),
    1060: ("XL430-W250", None),
    1190: ("XL330-M077", 1e-3),
    1200: ("XL330-M288", 1e-3),
}
"""Name and A per step of the present current, as each model's control table has them; None where
that register holds an estimated load instead."""


@dataclass(frozen=True, kw_only=True)
class DynamixelSettings:
    """The keys of an address; ``light`` is the servo's own LED, or on a line of the adapter."""

    id: Annotated[int, within(0, 252, "as a whole number")] = 1
    baud: Annotated[int, within(9600, 4_500_000, "bit/s")] = 57600
    light: Literal["none", "led", "dtr", "rts"] = "none"


class Dynamixel:
    """A servo of the X series in position mode."""

    def __init__(self, path: str, settings: DynamixelSettings, clock: Clock) -> None:
        """Open the port."""
        self.name = f"Dynamixel {settings.id} on {path}"
        self._id = settings.id
        self._port = Port(path, settings.baud, clock, self.name)
        self._ampere: float | None = None
        self.lamp: Lamp | None = None
        if settings.light == "led":
            self.lamp = OwnLed(self)
        elif settings.light != "none":
            self.lamp = LineLamp(self._port, settings.light)

    def connect(self, limits: Limits) -> None:
        """Ping the servo, and check mode, position limits and hardware errors."""
        parameters, _ = self._ask(codec.ping(self._id), 3)
        model = int.from_bytes(parameters[:2], "little")
        label, self._ampere = MODELS.get(model, (f"model {model}", None))
        self.name = self._port.name = f"{label}, id {self._id}"
        # At status return level 0 or 1 a write is not answered; this one may not be either.
        self._port.write(codec.write(self._id, codec.STATUS_RETURN_LEVEL, 2))
        mode = self._get(codec.OPERATING_MODE)
        if mode not in POSITION_MODES:
            raise InputError(
                f"{self.name}: operating mode is {mode}, expected 3 (position); set register 11 "
                f"with DYNAMIXEL Wizard"
            )
        low, high = self._get(codec.MIN_POSITION_LIMIT), self._get(codec.MAX_POSITION_LIMIT)
        if mode != 4 and not (low <= _steps(limits.low_deg) and _steps(limits.high_deg) <= high):
            raise InputError(
                f"{self.name}: its own limits are {_deg(low):.1f} to {_deg(high):.1f} deg, "
                f"expected to hold {limits.low_deg:g} to {limits.high_deg:g} deg; narrow the "
                f"limits of the run or set registers 52 and 48"
            )
        self._check_hardware()

    def enable(self, angle_deg: float) -> None:
        """Set the goal, switch the torque on, and start the servo's own watchdog."""
        self._set(codec.BUS_WATCHDOG, 0)
        self._set(codec.GOAL_POSITION, _steps(angle_deg))
        self._set(codec.TORQUE_ENABLE, 1)
        self._set(codec.BUS_WATCHDOG, WATCHDOG)

    def write(self, angle_deg: float) -> Sent:
        """Write the goal position (116), in steps of 0.088 deg."""
        steps = _steps(angle_deg)
        return Sent(self._set(codec.GOAL_POSITION, steps).asked_s, _deg(steps))

    def read(self) -> Reading:
        """Current, position, voltage and temperature (126 to 146) in one packet."""
        data, exchange = self._ask(codec.read(self._id, _FIRST, _COUNT), _COUNT)
        current = codec.value_of(codec.PRESENT_CURRENT, data, _FIRST)
        return Reading(
            time_s=exchange.middle_s,
            angle_deg=_deg(codec.value_of(codec.PRESENT_POSITION, data, _FIRST)),
            current_a=None if self._ampere is None else self._ampere * current,
            voltage_v=0.1 * codec.value_of(codec.PRESENT_INPUT_VOLTAGE, data, _FIRST),
            temperature_c=float(codec.value_of(codec.PRESENT_TEMPERATURE, data, _FIRST)),
        )

    def led(self, on: bool) -> float:
        """Switch the servo's LED (65); the time at which it has the order."""
        return self._set(codec.LED, int(on)).asked_s

    def disable(self) -> None:
        """Switch torque and watchdog off, also of a servo that reports a fault."""
        for register in (codec.TORQUE_ENABLE, codec.BUS_WATCHDOG):
            question = codec.write(self._id, register, 0)
            ask(self._port, question, lambda received: self._status(received, 0, faults=False))

    def close(self) -> None:
        """Let go of the port."""
        self._port.close()

    def _get(self, register: codec.Register) -> int:
        size = register.size
        data, _ = self._ask(codec.read(self._id, register.address, size), size)
        return codec.value_of(register, data, register.address)

    def _set(self, register: codec.Register, value: int) -> Exchange:
        return self._ask(codec.write(self._id, register, value), 0)[1]

    def _ask(self, question: bytes, size: int) -> tuple[bytes, Exchange]:
        return ask(self._port, question, lambda received: self._status(received, size), TRIES)

    def _status(self, received: bytes, size: int, faults: bool = True) -> bytes | None:
        """The parameters of this servo's status; None as long as there is none of that size."""
        for packet in codec.split(received)[0]:
            if packet.id != self._id or packet.error is None:
                continue
            number = packet.error & ~codec.ALERT
            if faults and packet.error & codec.ALERT:
                self._check_hardware()
            if faults and number and codec.ERRORS.get(number) != "CRC error":
                raise self._refusal(codec.ERRORS.get(number, f"error {number}"))
            if len(packet.parameters) == size and number == 0:
                return packet.parameters
        return None

    def _refusal(self, what: str) -> ServoFault:
        """Why the servo has refused: its watchdog, or something in its control table."""
        if self._peek(codec.BUS_WATCHDOG) == 255:
            return WatchdogTripped(
                f"{self.name}: the servo received nothing for {20e-3 * WATCHDOG:g} s and has "
                f"stopped; start again, and end other programs that keep the computer busy"
            )
        return ServoFault(f"{self.name}: the servo refuses ({what}); check its control table")

    def _check_hardware(self) -> None:
        """Raise ServoFault where the hardware error status (70) is not 0."""
        bits = self._peek(codec.HARDWARE_ERROR_STATUS)
        named = [what for bit, what in codec.HARDWARE_ERRORS.items() if bits >> bit & 1]
        if bits:
            raise ServoFault(
                f"{self.name}: the servo reports {' and '.join(named) or hex(bits)}; remove the "
                f"cause and switch its power off and on"
            )

    def _peek(self, register: codec.Register) -> int:
        """A register of one byte, also of a servo that reports a fault."""
        question = codec.read(self._id, register.address, 1)
        return ask(self._port, question, lambda got: self._status(got, 1, faults=False))[0][0]


class OwnLed:
    """The servo's own LED, on the order's last byte as far as its manual says (``Lamp``)."""

    sigma_s = LINE_SIGMA_S

    def __init__(self, servo: Dynamixel) -> None:
        self._servo = servo

    def switch(self, on: bool) -> float:
        """Switch it; the host's time of that, in s."""
        return self._servo.led(on)


def _steps(angle_deg: float) -> int:
    return round(STEPS / 2 + angle_deg * STEPS / 360.0)


def _deg(steps: int) -> float:
    return (steps - STEPS / 2) * 360.0 / STEPS
