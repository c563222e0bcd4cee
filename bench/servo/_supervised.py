"""A driver held to the limits of a run: what the rest of the bench moves."""

from __future__ import annotations

import math
from collections.abc import Callable

from servosight.bench.host_clock import Clock
from servosight.bench.safety import Limits, ramp
from servosight.bench.servo._protocol import (
    Driver,
    LinkLost,
    Reading,
    Sent,
    Servo,
    ServoFault,
    StoredPlayback,
    WatchdogTripped,
)
from servosight.models.core import InputError

_OUTSIDE_DEG = 1.0
"""How far outside its range a servo may stand when it is armed: its own resolution and play."""
_SPARE_S = 5.0
_PERSIST_S = 2.0
"""How long a release tries a link that is lost, from the last goal on that got through."""
_AGAIN_S = 0.12
"""Pause between two tries: after a gap of 100 ms a servo gives up a packet that it has begun."""


class SupervisedServo(Servo):
    """A ``Servo`` made of a driver.

    Whatever is sent, the servo receives no angle outside the range and no faster change than the
    rate: a goal that would be faster, because its sender was late, is approached at the rate, and
    ``goal_deg`` is the last goal that the servo was given. A goal after the duration, or before
    ``arm``, is refused. ``read`` raises ServoFault above the limits of temperature and current. The
    limit of the acceleration holds for commands, which ``check_command`` refuses, and for ramps.
    """

    def __init__(self, driver: Driver, limits: Limits, clock: Clock) -> None:
        """Take a driver that is connected."""
        self.driver = driver
        self.limits = limits
        self.clock = clock
        self.name = driver.name
        self.goal_deg: float | None = None
        self._sent_s = 0.0
        self._armed_s: float | None = None

    def arm(self) -> None:
        """Switch the torque on where the servo stands.

        A hobby servo does not say where that is: it starts at neutral, and jumps there.
        """
        limits = self.limits
        angle = self.read().angle_deg
        if angle is None:
            angle = limits.neutral_deg
        outside = max(limits.low_deg - angle, angle - limits.high_deg)
        if outside > _OUTSIDE_DEG:
            raise InputError(
                f"{self.name}: the servo stands at {angle:.1f} deg, expected {limits.low_deg:g} to "
                f"{limits.high_deg:g} deg; turn it there by hand or widen the limits"
            )
        self.goal_deg = min(max(angle, limits.low_deg), limits.high_deg)
        self._armed_s = self._sent_s = self.clock.now()  # from here on, release switches it off
        self.driver.enable(self.goal_deg)

    def send(self, angle_deg: float) -> Sent:
        """Command an angle; what the servo has of it, and when."""
        limits = self.limits
        if self._armed_s is None or self.goal_deg is None:
            raise InputError(f"{self.name}: the servo is not armed; call arm() first")
        if not limits.low_deg <= angle_deg <= limits.high_deg:
            raise InputError(
                f"{self.name}: asked for {angle_deg:g} deg, expected {limits.low_deg:g} to "
                f"{limits.high_deg:g} deg; make the command smaller or widen the limits"
            )
        now = self.clock.now()
        longest = limits.duration_s + 2.0 * self._longest_ramp_s() + _SPARE_S
        if now - self._armed_s > longest:
            raise InputError(
                f"{self.name}: armed for more than {longest:.0f} s; arm it again or raise the "
                f"limit of the duration"
            )
        return self._write(angle_deg, limits.rate_deg_s)

    def read(self) -> Reading:
        """What the servo measures; ServoFault above the limits."""
        reading = self.driver.read()
        for value, most, unit in (
            (reading.temperature_c, self.limits.temperature_c, "C"),
            (reading.current_a and abs(reading.current_a), self.limits.current_a, "A"),
        ):
            if value is not None and most is not None and value > most:
                raise ServoFault(
                    f"{self.name}: the servo reports {value:g} {unit}, expected at most {most:g} "
                    f"{unit}; let it cool, lighten its load or raise the limit"
                )
        return reading

    def move_to(self, angle_deg: float) -> None:
        """Ramp from the last goal to an angle within the range."""
        if self.goal_deg is None:
            raise InputError(f"{self.name}: the servo is not armed; call arm() first")
        time_s, ramp_deg = ramp(self.limits, self.goal_deg, angle_deg)
        start = self.clock.now()
        for at, goal in zip(time_s[1:].tolist(), ramp_deg[1:].tolist(), strict=True):
            self.clock.wait(start + at)
            self._write(goal, self.limits.ramp_rate_deg_s * 2.0)
        while self.goal_deg != angle_deg:  # late rows have shortened the ramp
            self.clock.wait(self.clock.now() + 0.02)
            self._write(angle_deg, self.limits.ramp_rate_deg_s)

    def release(self) -> None:
        """Ramp to neutral as far as the link allows, then switch the torque off in any case.

        A link that is lost is tried again for 2 s, for neutral and for the torque each.
        """
        if self._armed_s is None:
            return
        try:
            if not isinstance(self.driver, StoredPlayback):
                self._persist(self._neutral)
        finally:
            self._persist(self.driver.disable)
            self._armed_s = self.goal_deg = None

    def _neutral(self) -> None:
        try:
            self.move_to(self.limits.neutral_deg)
        except WatchdogTripped:
            angle = self.driver.read().angle_deg
            assert angle is not None  # who has a watchdog, measures
            self.goal_deg, self._sent_s = angle, self.clock.now()
            self.driver.enable(angle)
            self.move_to(self.limits.neutral_deg)

    def _persist(self, action: Callable[[], None]) -> None:
        start = self.clock.now()
        while True:
            try:
                return action()
            except LinkLost:
                if self.clock.now() >= max(start, self._sent_s) + _PERSIST_S:
                    raise
                self.clock.wait(self.clock.now() + _AGAIN_S)

    def close(self) -> None:
        """Release, and let go of the port."""
        try:
            self.release()
        finally:
            self.driver.close()

    def _longest_ramp_s(self) -> float:
        return float(ramp(self.limits, self.limits.low_deg, self.limits.high_deg)[0][-1])

    def _write(self, angle_deg: float, rate_deg_s: float | None) -> Sent:
        """Write a goal, or as much of the way to it as the rate and the time since allow."""
        assert self.goal_deg is not None
        step = angle_deg - self.goal_deg
        if rate_deg_s is not None:
            most = rate_deg_s * (self.clock.now() - self._sent_s)
            # Equal rows come with equal steps; rounding must not turn the last bit into a clamp.
            if abs(step) > most * (1.0 + 1e-6):
                angle_deg = self.goal_deg + math.copysign(most, step)
        sent = self.driver.write(angle_deg)
        self.goal_deg, self._sent_s = angle_deg, sent.time_s
        return sent
