"""A stand-in for the board: the state machine of ``bench/firmware/board.c`` in Python."""

from __future__ import annotations

from collections import deque

import numpy as np

from servosight.bench.light import lit
from servosight.bench.servo.codecs import board as codec
from servosight.bench.wire._plant import Plant
from servosight.bench.wire._standin import StandIn


class BoardStandIn(StandIn):
    """A board whose clock runs slow by ``slow_ppm``; 1500 us are 0 deg, and 1 us is 0.09 deg.

    ``plays`` lists when each command began and ended, by the wire's clock.
    """

    baud = 115200
    return_delay_s = 50e-6

    def __init__(self, plant: Plant, slow_ppm: float = 0.0) -> None:
        """A board that has just started."""
        super().__init__(plant)
        self._slow = 1.0 + 1e-6 * slow_ppm
        self._setup: codec.Setup | None = None
        self._state = codec.IDLE
        self._flags = self._silent = self._width = self._goal = 0
        self._period = self._began = self._played = self._expected = self._total = 0
        self._starting = False
        self._buffer: deque[int] = deque()
        self._rise_s = 0.0
        self._now_s = 0.0
        self.plays: list[tuple[float, float | None]] = []

    def lit(self, time_s: float) -> bool:
        """Whether the light is on at a time, by the wire's clock, up to now."""
        for began, ended in self.plays:
            if began <= time_s and (ended is None or time_s < ended):
                return bool(lit(np.array((time_s - began) / self._slow)))
        return False

    def advance(self, now_s: float) -> None:
        """Start the pulses that are due, and move."""
        self._now_s = now_s
        while self._setup and self._rise_s + self._period_s <= now_s:
            self._rise_s += self._period_s
            self._period += 1
            super().advance(self._rise_s)
            self._pulse()
        super().advance(now_s)

    def receive(self, data: bytes, now_s: float) -> list[bytes]:
        """Answer every whole packet."""
        packets, self._rest = codec.split(self.gathered(data, now_s))
        return [codec.encode(self._answer(packet, now_s)) for packet in packets]

    @property
    def _period_s(self) -> float:
        assert self._setup is not None
        return self._setup.period / codec.TICK_HZ * self._slow

    def _pulse(self) -> None:
        """What the firmware decides before a pulse, and the pulse."""
        setup, before = self._setup, (self._width, self._state)
        assert setup is not None
        if self._state == codec.IDLE:
            return
        if self._state != codec.RELEASING:
            self._silent += 1
            if self._silent > setup.silence:
                self._flags |= codec.LINK_LOST
                self._release()
        if self._state == codec.PLAYING:
            self._next_sample()
        if self._state == codec.RELEASING:
            if self._width == setup.neutral:
                self._state, self._width = codec.IDLE, 0
                self.take_goal(self._rise_s, self.goal_deg, False)
                return
            self._width = _towards(self._width, setup.neutral, setup.ramp)
        else:
            goal = min(max(self._goal, setup.low), setup.high)
            self._width = _towards(self._width, goal, setup.step)
        if (self._width, self._state) != before or not self.torque:
            self.take_goal(self._rise_s, (0.5 * self._width - 1500.0) * 0.09, True)

    def _next_sample(self) -> None:
        if not self._buffer:
            self._flags |= codec.STARVED if self._played != self._total else 0
            self._state = codec.ARMED
            self._dark()
            return
        if self._starting:
            self._starting = False
            self._began = self._period
            self.plays.append((self._rise_s, None))
        self._goal = self._buffer.popleft()
        self._played += 1

    def _release(self) -> None:
        self._state = codec.RELEASING
        self._dark()

    def _dark(self) -> None:
        if self.plays and self.plays[-1][1] is None:
            self.plays[-1] = (self.plays[-1][0], self._rise_s)

    def _answer(self, packet: codec.Packet, now_s: float) -> codec.Packet:
        self._silent = 0
        code = packet.code | codec.ANSWER
        if packet.code == codec.HELLO:
            about = bytes([codec.VERSION]) + codec.BUFFER.to_bytes(2, "little")
            return codec.Packet(code, about)
        tick = round((now_s - self._rise_s) / self._slow * codec.TICK_HZ) if self._setup else 0
        period = self._period
        self._take(packet, now_s)
        status = codec.Status(
            state=self._state,
            flags=self._flags,
            period=period,
            tick=tick,
            began=self._began,
            played=self._played,
            expected=self._expected,
            free=codec.BUFFER - len(self._buffer),
            width=self._width,
        )
        return codec.Packet(code, status.pack())

    def _take(self, packet: codec.Packet, now_s: float) -> None:
        if packet.code == codec.SETUP:
            setup = codec.Setup.unpack(packet.payload)
            if self._state != codec.IDLE:
                self._flags |= 0 if setup == self._setup else codec.REFUSED
                return
            self._setup, self._flags, self._rise_s = setup, 0, now_s
            self._played = self._expected = self._total = 0
        elif packet.code == codec.SET:
            if self._setup is None or self._state in (codec.PLAYING, codec.RELEASING):
                self._flags |= codec.REFUSED
                return
            self._goal = int.from_bytes(packet.payload, "little")
            if self._state == codec.IDLE:
                self._width, self._state = self._setup.neutral, codec.ARMED
        elif packet.code == codec.SAMPLES:
            first, widths = codec.samples_of(packet.payload)
            for number, width in enumerate(widths, first):
                if number == self._expected and len(self._buffer) < codec.BUFFER:
                    self._buffer.append(width)
                    self._expected += 1
        elif packet.code == codec.PLAY:
            end = int.from_bytes(packet.payload, "little")
            if self._state == codec.ARMED and end > self._played and self._buffer:
                self._total, self._starting, self._state = end, True, codec.PLAYING
            elif end != self._total:
                self._flags |= codec.REFUSED
        elif packet.code == codec.STOP and self._state != codec.IDLE:
            self._release()


def _towards(start: int, end: int, step: int) -> int:
    return start + max(-step, min(step, end - start))
