"""A stand-in that speaks Feetech's protocol and has the memory table of an STS3215."""

from __future__ import annotations

from servosight.bench.servo.codecs import feetech as codec
from servosight.bench.wire._plant import Plant
from servosight.bench.wire._standin import StandIn

_TABLE = 71
_FIRST_PRESENT = 56


class FeetechStandIn(StandIn):
    """An STS3215 in position mode: ping, read and write; a goal beyond its limits is clipped."""

    def __init__(self, plant: Plant, id: int = 1, baud: int = 1_000_000) -> None:
        """A servo as it comes out of its box."""
        super().__init__(plant)
        self.id, self.baud = id, baud
        self.return_delay_s = 100e-6
        self.table = bytearray(_TABLE)
        self.error = 0
        for register, value in (
            (codec.ID, id),
            (codec.MAX_ANGLE_LIMIT, 4095),
            (codec.GOAL_POSITION, 2048),
            (codec.LOCK, 1),
            (codec.PRESENT_VOLTAGE, 74),
        ):
            self.put(register, value)

    def put(self, register: codec.Register, value: int) -> None:
        """Set a register as the servo itself does."""
        data = value.to_bytes(register.size, "little")
        self.table[register.address : register.address + register.size] = data

    def get(self, register: codec.Register) -> int:
        """The value of a register."""
        return codec.value_of(register, bytes(self.table))

    def receive(self, data: bytes, now_s: float) -> list[bytes]:
        """Answer the instructions to this id."""
        packets, self._rest = codec.split(self.gathered(data, now_s))
        answers = []
        for packet in packets:
            if packet.id not in (self.id, codec.BROADCAST):
                continue
            answer = self._answer(packet, now_s)
            if answer is not None and (packet.id == self.id or packet.code == codec.PING):
                answers.append(codec.status(self.id, answer, self.error))
        return answers

    def _answer(self, packet: codec.Packet, now_s: float) -> bytes | None:
        given = packet.parameters
        if packet.code == codec.PING:
            return b""
        if packet.code == codec.READ and len(given) == 2 and sum(given) <= _TABLE:
            self._measure()
            return bytes(self.table[given[0] : given[0] + given[1]])
        if packet.code == codec.WRITE and len(given) > 1:
            start, end = given[0], given[0] + len(given) - 1
            if end <= _FIRST_PRESENT:
                self.table[start:end] = given[1:]
                self._move(start, end, now_s)
            return b""
        return None

    def _move(self, start: int, end: int, now_s: float) -> None:
        """Take a goal, within the limits of the servo's own, and the state of the torque."""
        steps = codec.signed(self.get(codec.GOAL_POSITION))
        low, high = self.get(codec.MIN_ANGLE_LIMIT), self.get(codec.MAX_ANGLE_LIMIT)
        if not low == high == 0:
            steps = max(low, min(high, steps))
        goal, torque = (steps - 2048) * 360.0 / 4096, self.get(codec.TORQUE_ENABLE) == 1
        if start <= codec.GOAL_POSITION.address < end or torque != self.torque:
            self.take_goal(now_s, goal, torque)

    def _measure(self) -> None:
        self.put(codec.PRESENT_POSITION, codec.unsigned(round(2048 + self.angle_deg * 4096 / 360)))
        self.put(codec.PRESENT_CURRENT, codec.unsigned(round(self.current_a / 6.5e-3)))
        self.put(codec.PRESENT_TEMPERATURE, round(self.temperature_c))
