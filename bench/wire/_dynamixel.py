"""A stand-in that speaks Dynamixel protocol 2.0 and has the control table of an XL330-M288."""

from __future__ import annotations

from servosight.bench.servo.codecs import dynamixel as codec
from servosight.bench.wire._plant import Plant
from servosight.bench.wire._standin import StandIn

MODEL, FIRMWARE = 1200, 52
_TABLE = 148
_EEPROM = 64
_RANGE_ERROR, _LENGTH_ERROR, _LIMIT_ERROR, _ACCESS_ERROR = 4, 5, 6, 7
_INSTRUCTION_ERROR = 2
_READ_ONLY = {0, 1, 2, 6, 70}
_FIRST_PRESENT = 120
_TICK_S = 20e-3


class DynamixelStandIn(StandIn):
    """An XL330 in position mode: ping, read and write, limits, errors, and the bus watchdog."""

    def __init__(self, plant: Plant, id: int = 1, baud: int = 57600) -> None:
        """A servo as it comes out of its box."""
        super().__init__(plant)
        self.id, self.baud = id, baud
        self.table = bytearray(_TABLE)
        self._heard_s = 0.0
        for register, value in (
            (codec.MODEL_NUMBER, MODEL),
            (codec.ID, id),
            (codec.RETURN_DELAY_TIME, 250),
            (codec.OPERATING_MODE, 3),
            (codec.MAX_POSITION_LIMIT, 4095),
            (codec.STATUS_RETURN_LEVEL, 2),
            (codec.GOAL_POSITION, 2048),
            (codec.PRESENT_INPUT_VOLTAGE, 50),
        ):
            self.put(register, value)
        self.table[6] = FIRMWARE

    def put(self, register: codec.Register, value: int) -> None:
        """Set a register as the servo itself does."""
        data = value.to_bytes(register.size, "little", signed=register.signed)
        self.table[register.address : register.address + register.size] = data

    def get(self, register: codec.Register) -> int:
        """The value of a register."""
        return codec.value_of(register, bytes(self.table))

    def advance(self, now_s: float) -> None:
        """Move, and stop by the bus watchdog (98) where nobody speaks any more."""
        allowed = self.get(codec.BUS_WATCHDOG)
        if self.torque and 0 < allowed < 128 and now_s - self._heard_s > allowed * _TICK_S:
            # The manual: the servo stops, and goals are refused until the register is cleared.
            self.put(codec.BUS_WATCHDOG, 255)
            self.take_goal(now_s, self.angle_deg, True)
        super().advance(now_s)

    def receive(self, data: bytes, now_s: float) -> list[bytes]:
        """Answer the instructions to this id."""
        self.return_delay_s = 2e-6 * self.get(codec.RETURN_DELAY_TIME)
        packets, self._rest = codec.split(self.gathered(data, now_s))
        answers = []
        for packet in packets:
            if packet.error is None and packet.id in (self.id, codec.BROADCAST):
                self._heard_s = now_s
                answers += self._answers(packet, now_s)
        return answers

    def _answers(self, packet: codec.Packet, now_s: float) -> list[bytes]:
        level = self.get(codec.STATUS_RETURN_LEVEL)
        if packet.instruction == codec.PING:
            return [self._status(bytes([MODEL & 0xFF, MODEL >> 8, FIRMWARE]))]
        if packet.id == codec.BROADCAST:
            return []
        if packet.instruction == codec.READ and len(packet.parameters) == 4:
            start = int.from_bytes(packet.parameters[:2], "little")
            size = int.from_bytes(packet.parameters[2:], "little")
            if start + size > _TABLE:
                return [self._status(error=_ACCESS_ERROR)]
            self._measure()
            return [self._status(bytes(self.table[start : start + size]))] if level else []
        if packet.instruction == codec.WRITE and len(packet.parameters) > 2:
            start = int.from_bytes(packet.parameters[:2], "little")
            error = self._write(start, packet.parameters[2:], now_s)
            level = self.get(codec.STATUS_RETURN_LEVEL)
            return [self._status(error=error)] if level == 2 else []
        return [self._status(error=_INSTRUCTION_ERROR)]

    def _write(self, start: int, data: bytes, now_s: float) -> int:
        """Write to the table; the number of the error, 0 without one."""
        end = start + len(data)
        if end > _FIRST_PRESENT or _READ_ONLY & set(range(start, end)):
            return _ACCESS_ERROR
        if start < _EEPROM and self.torque:
            return _ACCESS_ERROR
        at, size, _ = codec.GOAL_POSITION
        if start <= at < end:
            if end < at + size:
                return _LENGTH_ERROR
            goal = codec.value_of(codec.GOAL_POSITION, data, start)
            low, high = self.get(codec.MIN_POSITION_LIMIT), self.get(codec.MAX_POSITION_LIMIT)
            if self.get(codec.OPERATING_MODE) == 3 and not low <= goal <= high:
                return _LIMIT_ERROR
            if self.get(codec.BUS_WATCHDOG) == 255:
                return _RANGE_ERROR
        self.table[start:end] = data
        if start <= codec.LED.address < end:
            self.lamp.append((now_s, bool(self.get(codec.LED))))
        goal_deg = (self.get(codec.GOAL_POSITION) - 2048) * 360.0 / 4096
        torque = bool(self.get(codec.TORQUE_ENABLE))
        if start <= at < end or torque != self.torque:
            self.take_goal(now_s, goal_deg, torque)
        return 0

    def _measure(self) -> None:
        self.put(codec.PRESENT_POSITION, round(2048 + self.angle_deg * 4096 / 360.0))
        self.put(codec.PRESENT_CURRENT, round(1e3 * self.current_a))
        self.put(codec.PRESENT_TEMPERATURE, round(self.temperature_c))

    def _status(self, parameters: bytes = b"", error: int = 0) -> bytes:
        alert = codec.ALERT if self.get(codec.HARDWARE_ERROR_STATUS) else 0
        return codec.status(self.id, parameters, error | alert)
