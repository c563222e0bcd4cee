"""What the bench asks of a servo, and what a servo answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Protocol, runtime_checkable

from servosight.bench.safety import Limits
from servosight.models.core import Array, InputError


class LinkLost(InputError):
    """The servo answers no longer, or its port is gone; one sentence, as every InputError has."""


class ServoFault(InputError):
    """The servo reports a fault of its own, or exceeds a limit; one sentence."""


class WatchdogTripped(ServoFault):
    """The servo has stopped by itself because it received nothing; it can be enabled again."""


@dataclass(frozen=True, kw_only=True)
class Reading:
    """What a servo reports of itself; None for what it does not measure.

    ``time_s`` is the host's monotonic clock (``time.monotonic``, which V4L2 cameras use as well),
    halfway between the end of the question and the beginning of the answer.
    """

    time_s: float
    angle_deg: float | None = None
    current_a: float | None = None
    voltage_v: float | None = None
    temperature_c: float | None = None


class Sent(NamedTuple):
    """When a servo has a goal, by the host's monotonic clock, and which: its protocol rounds it.

    A step of 4096 a turn is 0.088 deg: a recording of the command before the rounding would blame
    the servo for it.
    """

    time_s: float
    angle_deg: float


class Lamp(Protocol):
    """A light in the picture that the host switches over the servo's own line.

    ``sigma_s`` is the standard deviation of when it really switches [s].
    """

    sigma_s: float

    def switch(self, on: bool) -> float:
        """Switch it; the host's time of that, in s."""


class Driver(Protocol):
    """What a kind of servo brings: its bytes, and nothing of limits, ramps or order of calls.

    Every method returns within the time-outs of ``bench.servo._port``; LinkLost and ServoFault.
    """

    name: str
    lamp: Lamp | None

    def connect(self, limits: Limits) -> None:
        """Find the servo and check that it is set up for what is to come; nothing moves."""

    def enable(self, angle_deg: float) -> None:
        """Switch the torque on with ``angle_deg`` as the goal."""

    def write(self, angle_deg: float) -> Sent:
        """Send a goal; what of it the servo has, and when."""

    def read(self) -> Reading:
        """Ask for what the servo measures."""

    def disable(self) -> None:
        """Switch the torque off, and see that it is off."""

    def close(self) -> None:
        """Let go of the port."""


@runtime_checkable
class StoredPlayback(Protocol):
    """A driver whose device plays a stored command by its own clock, and releases by itself.

    ``disable`` of such a driver moves the servo to neutral before it switches the torque off.
    """

    period_s: float

    def begin(self, angle_deg: Array) -> Array:
        """Store a command, (samples,), one each ``period_s``, and start it.

        Returns the angles as the device rounds them.
        """

    def feed(self) -> tuple[bool, int]:
        """Send what there is room for; whether the device plays on, and samples begun so far."""

    def start_and_rate(self) -> tuple[float, float]:
        """Host time of the first sample, in s, and host seconds per second of the device."""


@runtime_checkable
class PulseDriven(Protocol):
    """A driver whose device takes a goal with its next pulse, at an even rate of its own."""

    def follow(self, until_s: float) -> None:
        """Watch the pulses up to a time for the one with which the last goal takes effect."""

    def taken(self, sent: list[Sent]) -> tuple[list[Sent], float]:
        """The goals of a run when they took effect, and the standard deviation of that [s]."""


class Servo(Protocol):
    """A servo that is connected, and moves only between ``arm`` and ``release``.

    Angles are in degrees from the servo's own middle, positive in its own direction. Every method
    returns within the time-outs of its driver, and raises LinkLost where the servo does not answer.
    """

    name: str
    limits: Limits

    def arm(self) -> None:
        """Switch the torque on where the servo stands; it does not move."""

    def send(self, angle_deg: float) -> Sent:
        """Command an angle; the goal as the servo has it, and when: write and bytes on the wire.

        InputError for an angle outside the limits and for a servo that is not armed.
        """

    def read(self) -> Reading:
        """Ask the servo for what it measures."""

    def release(self) -> None:
        """Move to neutral within the limits, as far as the link allows, and switch torque off."""

    def close(self) -> None:
        """Release, and let go of the port."""
