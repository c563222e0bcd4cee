"""Hobby servos behind a Pololu Maestro. The codec's docstring names the manual."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from servosight.bench.host_clock import Clock
from servosight.bench.safety import Limits
from servosight.bench.servo._port import TRIES, Port, ask
from servosight.bench.servo._protocol import LinkLost, Reading, ServoFault
from servosight.bench.servo.codecs import maestro as codec
from servosight.models.core import InputError, within

PULSE_S = 0.02
"""The Maestro's pulse period as it comes."""
LOWEST_US, HIGHEST_US = 400.0, 2600.0
"""Pulse widths beyond which no hobby servo is meant to go."""


@dataclass(frozen=True, kw_only=True)
class MaestroSettings:
    """The keys of an address; ``device`` selects the Pololu protocol, ``crc`` as set in the "
    "Maestro."""

    channel: Annotated[int, within(0, 23, "as a whole number")] = 0
    device: Annotated[int, within(0, 127, "as a whole number")] | None = None
    crc: bool = False
    neutral_us: Annotated[float, within(800.0, 2200.0, "us")] = 1500.0
    deg_per_us: Annotated[float, within(-1.0, 1.0, "deg/us")] = 0.09
    baud: Annotated[int, within(9600, 1_000_000, "bit/s")] = 115200


class Maestro:
    """One channel of a Maestro. The servo reports nothing: its angle is the camera's to measure.

    The Maestro acknowledges no target, so a damaged one is found only where its CRC is enabled.
    """

    def __init__(self, path: str, settings: MaestroSettings, clock: Clock) -> None:
        """Open the port."""
        self.name = f"Maestro channel {settings.channel} on {path}"
        self._settings = settings
        self._speed = self._last = 0
        self._clock = clock
        self._port = Port(path, settings.baud, clock, self.name)
        if settings.deg_per_us == 0.0:
            self.close()
            raise InputError(
                f"{self.name}: deg_per_us is 0, expected degrees per microsecond of pulse, such as "
                f"0.09; correct the address"
            )

    def connect(self, limits: Limits) -> None:
        """Check that a Maestro answers, and that the limits are pulses of a hobby servo."""
        for angle in (limits.low_deg, limits.high_deg):
            if not LOWEST_US <= (width := self._width_us(angle)) <= HIGHEST_US:
                raise InputError(
                    f"{self.name}: {angle:g} deg is a pulse of {width:.0f} us, expected "
                    f"{LOWEST_US:.0f} to {HIGHEST_US:.0f} us; narrow the limits or correct "
                    "deg_per_us"
                )
        if limits.rate_deg_s is not None:
            rate_us_s = limits.rate_deg_s / abs(self._settings.deg_per_us)
            self._speed = min(math.ceil(rate_us_s / codec.SPEED_US_S), codec.FASTEST)
        self._ask(codec.get_errors(self._settings.device))  # which clears old ones
        self._position()

    def enable(self, angle_deg: float) -> None:
        """Start the pulses; the Maestro itself holds them to the rate, from pulse to pulse."""
        for _ in range(TRIES):  # the Maestro does not acknowledge it, but it notes a damaged one
            self._send(codec.set_speed(self._settings.channel, self._speed, self._settings.device))
            if self._ask(codec.get_errors(self._settings.device))[0] == 0:
                break
        self.write(angle_deg)

    def write(self, angle_deg: float) -> float:
        """Set the target; the Maestro uses it from its next pulse on."""
        self._last = round(codec.QUARTERS * self._width_us(angle_deg))
        return self._target(self._last)

    def read(self) -> Reading:
        """Ask for errors; LinkLost without an answer, ServoFault after the Maestro's time-out."""
        errors, middle = self._ask(codec.get_errors(self._settings.device))
        if errors & codec.TIMEOUT_ERROR:
            raise ServoFault(
                f"{self.name}: the Maestro has stopped the servo after its serial time-out; set a "
                f"longer time-out in Pololu's Maestro Control Center"
            )
        return Reading(time_s=middle)

    def disable(self) -> None:
        """Stop the pulses after one with the last goal, and see that they have stopped."""
        if self._last:
            self._target(self._last)  # once more: nothing has acknowledged it
        self._clock.wait(self._clock.now() + PULSE_S)
        for _ in range(TRIES):
            self._target(0)
            if self._position() == 0:
                return
        raise LinkLost(f"{self.name}: the pulses do not stop; switch the servo's power off")

    def close(self) -> None:
        """Let go of the port."""
        self._port.close()

    def _width_us(self, angle_deg: float) -> float:
        return self._settings.neutral_us + angle_deg / self._settings.deg_per_us

    def _target(self, quarters: int) -> float:
        return self._send(codec.set_target(self._settings.channel, quarters, self._settings.device))

    def _position(self) -> int:
        return self._ask(codec.get_position(self._settings.channel, self._settings.device))[0]

    def _send(self, command: codec.Command) -> float:
        return self._port.write(codec.encode(command, self._settings.crc))

    def _ask(self, command: codec.Command) -> tuple[int, float]:
        """The two-byte answer to a command, and the time of it."""
        question = codec.encode(command, self._settings.crc)
        answer, exchange = ask(self._port, question, lambda got: got if len(got) == 2 else None)
        return int.from_bytes(answer, "little"), exchange.middle_s
