"""A stand-in for a Maestro with a hobby servo on one of its channels."""

from __future__ import annotations

import math

from servosight.bench.servo.codecs import maestro as codec
from servosight.bench.wire._plant import Plant
from servosight.bench.wire._standin import StandIn


class MaestroStandIn(StandIn):
    """A Mini Maestro: targets take effect at the next pulse, each ``period_s``.

    ``output`` is a channel that is a digital output. A
    target is clipped to the channel's ``low_us`` and ``high_us``, as the Maestro's settings do.
    """

    def __init__(
        self,
        plant: Plant,
        *,
        channel: int = 0,
        output: int = 5,
        crc: bool = False,
        low_us: float = 992.0,
        high_us: float = 2000.0,
        period_s: float = 0.02,
        timeout_s: float = math.inf,
    ) -> None:
        """A Maestro as it comes out of its box; ``timeout_s`` is its serial time-out."""
        super().__init__(plant)
        self.baud = 115200
        self.return_delay_s = 200e-6
        self.channel, self._output, self._crc = channel, output, crc
        self._low, self._high = round(4 * low_us), round(4 * high_us)
        self._period_s, self._timeout_s = period_s, timeout_s
        self._target = 0
        self._pulse = self._speed = 0
        self._pulse_s = 0.0
        self._heard_s = 0.0
        self._errors = 0

    def advance(self, now_s: float) -> None:
        """Start the pulses that are due, and move."""
        if self._target and now_s - self._heard_s > self._timeout_s:
            self._errors |= codec.TIMEOUT_ERROR
            self._target = 0
        if self._pulse_s == 0.0:
            self._pulse_s = now_s
        while self._pulse_s + self._period_s <= now_s:
            self._pulse_s += self._period_s
            super().advance(self._pulse_s)
            if (pulse := self._next_pulse()) != self._pulse:
                self._pulse = pulse
                goal = (self._pulse / codec.QUARTERS - 1500.0) * 0.09 if self._pulse else 0.0
                self.take_goal(
                    self._pulse_s, goal if self._pulse else self.goal_deg, self._pulse > 0
                )
        super().advance(now_s)

    def _next_pulse(self) -> int:
        """The next pulse's width, the target or as near to it as the speed allows; 0 is none."""
        if not (self._target and self._pulse and self._speed):
            return self._target
        most = math.floor(self._speed * codec.SPEED_US_S * codec.QUARTERS * self._period_s)
        return self._pulse + max(-most, min(most, self._target - self._pulse))

    def receive(self, data: bytes, now_s: float) -> list[bytes]:
        """Take commands; answer those that ask."""
        commands, self._rest, errors = codec.split(self.gathered(data, now_s), self._crc)
        self._errors |= errors
        answers = []
        for command in commands:
            self._heard_s = now_s
            if command.code == codec.SET_TARGET:
                channel, target = codec.target_of(command)
                if channel == self._output:
                    self.lamp.append((now_s, target >= 1500 * codec.QUARTERS))
                elif channel == self.channel:
                    self._target = max(self._low, min(self._high, target)) if target else 0
            elif command.code == codec.SET_SPEED and command.data[0] == self.channel:
                self._speed = codec.target_of(command)[1]
            elif command.code == codec.GET_POSITION:
                # The pulse that is being sent, not the target that waits for the next one.
                here = self._pulse if command.data[0] == self.channel else 0
                answers.append(here.to_bytes(2, "little"))
            elif command.code == codec.GET_ERRORS:
                answers.append(self._errors.to_bytes(2, "little"))
                self._errors = 0
        return answers
