"""Hobby servos behind a Pololu Maestro. The codec's docstring names the manual."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from servosight.bench.host_clock import Clock
from servosight.bench.safety import Limits
from servosight.bench.servo._port import TRIES, Port, ask
from servosight.bench.servo._protocol import Lamp, LinkLost, Reading, Sent, ServoFault
from servosight.bench.servo._pulses import Shown, pulse_train
from servosight.bench.servo.codecs import maestro as codec
from servosight.models.core import InputError, within

PULSE_S = 0.02
"""The Maestro's pulse period as it comes."""
_SPARE = 1.2
"""A pulse has come after this many periods: the two clocks differ."""
_POLL_S = 0.5e-3
_GOLDEN = 0.618034
_PROBES = 3
HIGH, LOW = 8000, 4000
"""Targets of a channel that is a digital output: from 6000 quarters on it is high (5.e)."""
OUTPUT_SIGMA_S = 1e-3
"""The manual does not say how soon an output follows its order."""
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
    light_channel: Annotated[int, within(0, 23, "as a whole number")] | None = None
    period_ms: Annotated[float, within(3.0, 32.0, "ms")] = 1e3 * PULSE_S
    baud: Annotated[int, within(9600, 1_000_000, "bit/s")] = 115200


class Maestro:
    """One channel of a Maestro. The servo reports nothing: its angle is the camera's to measure.

    A target takes effect with the next pulse, and GET_POSITION answers with the pulse that is being
    sent (section 5.e), so that asking shows when that is.

    The Maestro acknowledges no target, so a damaged one is found only where its CRC is enabled.
    """

    def __init__(self, path: str, settings: MaestroSettings, clock: Clock) -> None:
        """Open the port."""
        self.name = f"Maestro channel {settings.channel} on {path}"
        self._settings = settings
        self._speed = self._before = self._last = self._shown = 0
        self.lamp: Lamp | None = None
        if settings.light_channel is not None:
            self.lamp = OutputLamp(self, settings.light_channel)
        self._period_s = 1e-3 * settings.period_ms
        self._cost_s = self._wrote_s = self._taken_s = 0.0
        self._asked_s = -math.inf
        self._waits = False
        self._pulses: list[tuple[float, float]] = []
        self._answers: list[Shown] = []
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
        self._look_for_pulses()

    def write(self, angle_deg: float) -> Sent:
        """Set the target, in quarter microseconds; the Maestro uses it from its next pulse on."""
        self._before, self._last = self._last, round(codec.QUARTERS * self._width_us(angle_deg))
        self._wrote_s = self._clock.now()
        self._taken_s = self._target(self._last)
        return Sent(self._taken_s, self._angle_deg(self._last))

    def output(self, channel: int, high: bool) -> float:
        """Set a channel that is a digital output; the time at which the Maestro has the order."""
        target = HIGH if high else LOW
        return self._send(codec.set_target(channel, target, self._settings.device))

    def follow(self, until_s: float) -> None:
        """Ask for the pulse that is being sent until it is the last goal's, or until a time."""
        # Rows come as evenly as pulses: without a shift of its own each time, the questions would
        # always leave the same gap about a pulse.
        shift = math.modf(_GOLDEN * len(self._pulses))[0]
        self._clock.wait(self._clock.now() + shift * (self._cost_s + _POLL_S))
        while self._shown != self._last and self._clock.now() + 2.0 * self._cost_s < until_s:
            asked_s = self._clock.now()
            position = self._position()
            answered_s = self._clock.now()
            self._cost_s = answered_s - asked_s
            self._answers.append(Shown(asked_s, answered_s, self._angle_deg(position)))
            if position != self._shown:
                self._note_pulse(position, answered_s)
            self._shown, self._asked_s = position, asked_s
            self._clock.wait(answered_s + _POLL_S)

    def _note_pulse(self, position: int, answered_s: float) -> None:
        """A pulse began since the last question, before this answer; the order says more."""
        low, high = self._asked_s, answered_s
        if self._waits and self._last != self._before:
            if position == self._last:
                low = max(low, self._wrote_s)
            elif position == self._before:
                high = min(high, self._taken_s)
        if high - low < 0.5 * self._period_s:
            self._pulses.append((low, high))

    def _look_for_pulses(self) -> None:
        """See whether answers wait for the next pulse: change the target by its least step.

        At times that fall at many phases of the pulses; once seen, it is known.
        """
        self._clock.wait(self._clock.now() + _SPARE * self._period_s)
        self._waits, self._shown = False, self._position()
        for change in (1, 0) * _PROBES:
            self._target(self._last + change)
            if self._position() != self._last + change:
                self._waits = True
            self._clock.wait(self._clock.now() + (1.0 + _GOLDEN) * self._period_s)
        self._shown = self._position()

    def taken(self, sent: list[Sent]) -> tuple[list[Sent], float]:
        """Goals at the pulses that were seen; half a period later where none were."""
        train, answers = pulse_train(self._pulses, self._period_s), self._answers
        self._pulses, self._answers = [], []
        if train is not None:
            return train.taken(sent, answers)
        late = [Sent(one.time_s + 0.5 * self._period_s, one.angle_deg) for one in sent]
        return late, self._period_s / math.sqrt(12.0)

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
        self._clock.wait(self._clock.now() + _SPARE * self._period_s)
        for _ in range(TRIES):
            self._target(0)
            self._clock.wait(self._clock.now() + _SPARE * self._period_s)
            if self._position() == 0:
                return
        raise LinkLost(f"{self.name}: the pulses do not stop; switch the servo's power off")

    def close(self) -> None:
        """Let go of the port."""
        self._port.close()

    def _width_us(self, angle_deg: float) -> float:
        return self._settings.neutral_us + angle_deg / self._settings.deg_per_us

    def _angle_deg(self, quarters: int) -> float:
        """The angle of a pulse; of equal pulses exactly the same."""
        width_us = quarters / codec.QUARTERS
        return (width_us - self._settings.neutral_us) * self._settings.deg_per_us

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


class OutputLamp:
    """A light on a channel that is a digital output (``Lamp``)."""

    sigma_s = OUTPUT_SIGMA_S

    def __init__(self, maestro: Maestro, channel: int) -> None:
        self._maestro, self._channel = maestro, channel

    def switch(self, on: bool) -> float:
        """Switch it; the host's time of that, in s."""
        return self._maestro.output(self._channel, on)
