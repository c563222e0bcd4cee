"""Hobby servos behind a board with the firmware of ``bench.firmware``."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from servosight.bench.host_clock import Clock
from servosight.bench.safety import Limits
from servosight.bench.servo._port import Port, ask
from servosight.bench.servo._protocol import Lamp, LinkLost, Reading, Sent, ServoFault
from servosight.bench.servo.codecs import board as codec
from servosight.models.core import Array, InputError, within

BAUD = 115200
START_S = 3.0
"""Opening the port resets an Arduino; its boot loader takes up to 2 s."""
SILENCE_S = 0.5
_MOST = 65535
_LOWEST, _HIGHEST = 800, 5200
"""Pulse widths in ticks that the firmware accepts: 400 to 2600 us."""
_POLL_S = 0.02


@dataclass(frozen=True, kw_only=True)
class BoardSettings:
    """The keys of an address."""

    neutral_us: Annotated[float, within(800.0, 2200.0, "us")] = 1500.0
    deg_per_us: Annotated[float, within(-1.0, 1.0, "deg/us")] = 0.09
    period_ms: Annotated[int, within(4, 32, "ms")] = 20


class Board:
    """A servo on pin 9 of a board, and the coded light on pin 11.

    The board holds the limits itself, plays a command by its own clock, and brings the servo to
    neutral at the request to stop, and when it receives nothing any more.
    """

    def __init__(self, path: str, settings: BoardSettings, clock: Clock) -> None:
        """Open the port, which resets an Arduino."""
        self.name = f"board on {path}"
        self.lamp: Lamp | None = None  # the board drives its light itself
        self.period_s = 1e-3 * settings.period_ms
        self._settings = settings
        self._clock = clock
        self._port = Port(path, BAUD, clock, self.name)
        self._command: list[int] = []
        self._first = 0
        self._seen: list[tuple[float, float]] = []
        self._releases_s = 0.0
        self._limits = Limits()

    def connect(self, limits: Limits) -> None:
        """Wait for the board to start, check its firmware, and set its limits."""
        self._limits = limits
        version = self._hello()
        if version != codec.VERSION:
            raise InputError(
                f"{self.name}: the firmware has version {version}, expected {codec.VERSION}; write "
                f"the firmware of this version of servosight to the board"
            )
        setup = self._setup(limits)
        if not _LOWEST <= setup.low < setup.high <= _HIGHEST:
            raise InputError(
                f"{self.name}: the limits are pulses of {0.5 * setup.low:.0f} to "
                f"{0.5 * setup.high:.0f} us, expected 400 to 2600 us; narrow the limits or correct "
                f"deg_per_us"
            )
        if setup.high + 1000 >= setup.period:
            raise InputError(
                f"{self.name}: pulses of {0.5 * setup.high:.0f} us do not fit into "
                f"{self._settings.period_ms} ms; choose a longer period_ms or narrow the limits"
            )
        longest = max(setup.high - setup.neutral, setup.neutral - setup.low)
        self._releases_s = (longest / setup.ramp + 4.0) * self.period_s
        self.disable()  # pulses of an earlier run: limits are set while there are none
        status, _ = self._ask(codec.Packet(codec.SETUP, setup.pack()))
        if status.flags & codec.REFUSED:
            raise ServoFault(f"{self.name}: the board refuses its limits; switch it off and on")

    def enable(self, angle_deg: float) -> None:
        """Start the pulses, at neutral."""
        self.write(angle_deg)

    def write(self, angle_deg: float) -> Sent:
        """Set the width of the pulses from the next one on."""
        ticks = self._ticks(angle_deg)
        packet = codec.Packet(codec.SET, ticks.to_bytes(2, "little"))
        return Sent(self._checked(packet).time_s, self._deg(ticks))

    def read(self) -> Reading:
        """Ask for the state of the board; the servo itself reports nothing."""
        return self._checked(codec.Packet(codec.STATUS))

    def disable(self) -> None:
        """Let the board move the servo to neutral and stop the pulses, and see that they stop."""
        until = self._clock.now() + self._releases_s + 1.0
        while self._ask(codec.Packet(codec.STOP))[0].state != codec.IDLE:
            if self._clock.now() > until:
                raise LinkLost(f"{self.name}: the pulses do not stop; switch the servo's power off")
            self._clock.wait(self._clock.now() + _POLL_S)

    def close(self) -> None:
        """Let go of the port."""
        self._port.close()

    def begin(self, angle_deg: Array) -> Array:
        """Store the command, a sample a pulse, and start it; the angles that the pulses stand for.

        ``feed`` is to be called until it returns False.
        """
        self._command = [self._ticks(angle) for angle in angle_deg.tolist()]
        status, _ = self._ask(codec.Packet(codec.STATUS))
        self._first = status.expected
        self._seen.clear()
        for _ in range(codec.BUFFER // codec.MOST_SAMPLES + 1):
            if (stored := status.expected - self._first) < len(self._command) and status.free:
                status = self._store(stored)
        end = (self._first + len(self._command)).to_bytes(4, "little")
        self._checked(codec.Packet(codec.PLAY, end))
        return np.array([self._deg(ticks) for ticks in self._command])

    def feed(self) -> tuple[bool, int]:
        """Send what the board has room for; whether it plays on, and how many pulses have begun."""
        status, at = self._ask(codec.Packet(codec.STATUS))
        if status.state == codec.PLAYING and status.played > self._first:
            board_s = (status.period - status.began) * self.period_s + status.tick / codec.TICK_HZ
            self._seen.append((board_s, at))
        stored = status.expected - self._first
        if stored < len(self._command) and status.free >= codec.MOST_SAMPLES:
            status = self._store(stored)
        self._check(status)
        if status.flags & codec.STARVED:
            raise LinkLost(
                f"{self.name}: the command did not reach the board in time; use a shorter USB "
                f"cable, or end other programs that keep the computer busy"
            )
        played = status.played - self._first
        return played < len(self._command) or status.state == codec.PLAYING, played

    def start_and_rate(self) -> tuple[float, float]:
        """When the first pulse and the light began on the host's clock, and host per board second.

        By least squares through all exchanges of the run; a rate needs 2 s of them. The board's own
        resonator may be wrong by some 1e-3.
        """
        if not self._seen:
            return self._clock.now(), 1.0
        board_s, host_s = (np.array(column) for column in zip(*self._seen, strict=True))
        if board_s[-1] - board_s[0] < 2.0:
            return float(np.median(host_s - board_s)), 1.0
        rate, start = np.polyfit(board_s, host_s - host_s[0], 1)
        return float(start + host_s[0]), float(rate)

    def _hello(self) -> int:
        until = self._clock.now() + START_S
        while True:
            try:
                answer, _ = ask(
                    self._port,
                    codec.encode(codec.Packet(codec.HELLO)),
                    lambda received: self._answer(received, codec.HELLO),
                    tries=1,
                )
            except LinkLost:
                if self._clock.now() > until:
                    raise
                self._clock.wait(self._clock.now() + _POLL_S)  # a port that is gone fails at once
            else:
                return answer[0]

    def _setup(self, limits: Limits) -> codec.Setup:
        ends = sorted((self._ticks(limits.low_deg), self._ticks(limits.high_deg)))
        rate = limits.rate_deg_s
        return codec.Setup(
            period=2000 * self._settings.period_ms,
            low=ends[0],
            high=ends[1],
            neutral=self._ticks(limits.neutral_deg),
            step=_MOST if rate is None else self._step(rate),
            ramp=self._step(limits.ramp_rate_deg_s),
            silence=math.ceil(SILENCE_S / self.period_s),
        )

    def _ticks(self, angle_deg: float) -> int:
        return round(2.0 * (self._settings.neutral_us + angle_deg / self._settings.deg_per_us))

    def _deg(self, ticks: int) -> float:
        return (0.5 * ticks - self._settings.neutral_us) * self._settings.deg_per_us

    def _step(self, rate_deg_s: float) -> int:
        """Ticks from pulse to pulse; one more, because both ends of a step are rounded."""
        step = 2.0 * rate_deg_s * self.period_s / abs(self._settings.deg_per_us)
        return min(_MOST, math.floor(step) + 1)

    def _store(self, stored: int) -> codec.Status:
        some = self._command[stored : stored + codec.MOST_SAMPLES]
        return self._ask(codec.samples(self._first + stored, some))[0]

    def _checked(self, packet: codec.Packet) -> Reading:
        status, at = self._ask(packet)
        self._check(status)
        return Reading(time_s=at)

    def _check(self, status: codec.Status) -> None:
        if status.flags & codec.LINK_LOST:
            raise ServoFault(
                f"{self.name}: the board received nothing for {SILENCE_S:g} s and has released the "
                f"servo; start again, and end other programs that keep the computer busy"
            )
        if status.flags & codec.REFUSED:
            raise ServoFault(f"{self.name}: the board refuses; switch it off and on")

    def _ask(self, packet: codec.Packet) -> tuple[codec.Status, float]:
        """The board's status after a packet, and the time of it."""
        payload, exchange = ask(
            self._port, codec.encode(packet), lambda received: self._answer(received, packet.code)
        )
        return codec.Status.unpack(payload), exchange.middle_s

    @staticmethod
    def _answer(received: bytes, code: int) -> bytes | None:
        found = codec.split(received)[0]
        return next((one.payload for one in found if one.code == code | codec.ANSWER), None)
