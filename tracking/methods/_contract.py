"""The contract of a tracking method."""

from __future__ import annotations

from typing import Protocol

from servosight.models.core import FrameProgress
from servosight.tracking.core import Track, TrackOptions
from servosight.tracking.video import Film


class Method(Protocol):
    """One way from a video to its angles; an entry in ``METHODS``.

    A method that measures frame after frame gives ``track_frames`` an estimator of its own; one
    that works otherwise (see ``_marker.py``) makes the ``Track`` itself.
    """

    def __call__(
        self, film: Film, options: TrackOptions, progress: FrameProgress | None = None
    ) -> Track:
        """Measure a checked video; ``InputError`` where it does not show what is asked for."""
        ...
