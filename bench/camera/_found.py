"""A camera of this computer, as a list of them has it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class FoundCamera:
    """A camera in one of its modes, by the ``device`` that an address begins with.

    ``coding`` (such as MJPG), ``size`` (width, height) [px] and ``rates_hz`` are those of the mode:
    none where the camera does not list its modes, no rates where it takes any. ``fault`` says why
    it cannot be used.

    >>> usb = FoundCamera(device="v4l2:/dev/video0", name="A camera", coding="MJPG",
    ...                   size=(640, 480), rates_hz=(60.0, 120.0))
    >>> print(usb)
    v4l2:/dev/video0  A camera  MJPG 640 x 480 at 60, 120 frames/s
    >>> usb.address
    'v4l2:/dev/video0?format=MJPG&width=640&height=480&rate=120'
    """

    device: str
    name: str
    coding: str = ""
    size: tuple[int, int] | None = None
    rates_hz: tuple[float, ...] = ()
    fault: str | None = None

    @property
    def rate_hz(self) -> float | None:
        """The mode's fastest rate; None where it is not listed."""
        return max(self.rates_hz, default=None)

    @property
    def address(self) -> str:
        """What ``open_camera`` takes: the mode at its fastest rate."""
        if self.size is None:
            return self.device
        width, height = self.size
        rate = "" if self.rate_hz is None else f"&rate={self.rate_hz:g}"
        return f"{self.device}?format={self.coding}&width={width}&height={height}{rate}"

    def __str__(self) -> str:
        """A line of the list."""
        if self.fault is not None:
            return f"{self.device}: {self.fault}"
        if self.size is None:
            return f"{self.device}  {self.name}"
        rates = ", ".join(f"{rate:.4g}" for rate in self.rates_hz) or "any"
        width, height = self.size
        return f"{self.device}  {self.name}  {self.coding} {width} x {height} at {rates} frames/s"
