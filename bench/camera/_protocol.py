"""What the bench asks of a camera."""

from __future__ import annotations

from typing import Protocol


class Camera(Protocol):
    """A camera that is open."""

    name: str

    def close(self) -> None:
        """Stop the stream and let go of the device."""
