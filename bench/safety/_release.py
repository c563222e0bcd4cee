"""The one place that makes sure that a servo is released."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol, TypeVar


class Releasable(Protocol):
    """What can be armed and released: a servo."""

    def arm(self) -> None:
        """Switch the torque on."""

    def release(self) -> None:
        """Move to neutral where the link allows it, and switch the torque off."""


T = TypeVar("T", bound=Releasable)


@contextmanager
def released(servo: T) -> Iterator[T]:
    """Arm a servo for the body of a ``with``, and release it whatever ends the body.

    An exception, Ctrl-C and a lost link all pass through here. An exception of the body is the one
    that is raised, also where the release fails after it.

    >>> class Lamp:
    ...     def arm(self): print("on")
    ...     def release(self): print("off")
    >>> with released(Lamp()):
    ...     print("lit")
    on
    lit
    off
    """
    try:
        servo.arm()
        yield servo
    except BaseException as reason:
        try:
            servo.release()
        except Exception as second:
            reason.add_note(f"and the servo could not be released: {second}")
        raise
    servo.release()
