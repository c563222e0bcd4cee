"""What the bench asks of a camera."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from typing import Annotated, Literal, Protocol

from servosight.bench.timing import Meaning
from servosight.models.core import InputError, check_fields, either, within

Coding = Literal["mjpeg", "gray"]
"""A picture as the camera compressed it, or one byte for each pixel."""


Now = Callable[[], float]
"""The host's monotonic time [s], by which commands are sent."""


class CameraLost(InputError):
    """The camera delivers no more frames; one sentence, as every InputError has."""


@dataclass(frozen=True, kw_only=True)
class CapturedFrame:
    """One picture as it came.

    ``number`` is the camera's own count, in which a gap is a lost frame; ``stamp_s`` the time that
    the camera gave it, on its own clock; ``arrival_s`` when the host had it, on ``time.monotonic``.
    """

    number: int
    stamp_s: float
    arrival_s: float
    data: bytes


@dataclass(frozen=True, kw_only=True)
class Stream:
    """What is known of a camera's pictures: ``size`` is width and height [px].

    ``meaning`` says what a stamp is. ``rate_hz`` is the declared frame rate; rate, exposure and
    readout are None where the camera does not say. ``settings`` are controls as they were read
    back from the camera, by name.
    """

    size: tuple[int, int]
    coding: Coding
    meaning: Meaning
    rate_hz: float | None = None
    exposure_s: float | None = None
    readout_s: float | None = None
    settings: tuple[tuple[str, float], ...] = ()
    host_clock: bool = False


_GIVEN = {
    "exposure_s": either("exposure_s", "--exposure"),
    "readout_s": either("readout_s", "--readout"),
    "meaning": either("meaning", "--stamp"),
}
"""How the user gives what a ``Given`` holds."""


@dataclass(frozen=True, kw_only=True)
class Given:
    """What the user states of a camera in place of what it says itself.

    Exposure and readout [s] from the data sheet or from the camera's own page, and what a stamp
    means. ``timeout_s`` is the longest wait for a frame.
    """

    exposure_s: Annotated[float, within(1e-6, 1.0, "seconds")] | None = None
    readout_s: Annotated[float, within(0.0, 1.0, "seconds")] | None = None
    meaning: Meaning | None = None
    timeout_s: Annotated[float, within(0.1, 60.0, "seconds")] = 5.0

    def __post_init__(self) -> None:
        """Raise InputError for values out of range."""
        check_fields(self, "camera", given_as=lambda key: _GIVEN.get(key, key))

    def over(self, stream: Stream) -> Stream:
        """``stream`` with what is given here."""
        stated = {
            "exposure_s": self.exposure_s,
            "readout_s": self.readout_s,
            "meaning": self.meaning,
        }
        return replace(stream, **{k: v for k, v in stated.items() if v is not None})  # type: ignore[arg-type]


class OpenCamera(Protocol):
    """A camera that is open and delivers frames."""

    name: str
    stream: Stream

    def frames(self) -> Generator[CapturedFrame]:
        """Frames as they come from now on. CameraLost where none comes in time; a file ends."""

    def close(self) -> None:
        """Stop the stream and let go of the device; a second call does nothing."""


def check_size(name: str, size: tuple[int, int]) -> None:
    """Raise InputError for a picture size that no camera of the bench has."""
    largest = 8192
    if not all(32 <= side <= largest for side in size):
        raise InputError(
            f"{name}: pictures of {size[0]} x {size[1]} px; expected 32 to {largest} px a side, "
            f"choose another mode of the camera"
        )
