"""A video that cannot be tracked, with a picture of what was found in it."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

from servosight.models.core import Image, InputError
from servosight.tracking.core._track import Track


class TrackRefused(InputError):
    """A video in which no angle could be measured that the frames confirm.

    ``draw`` makes the ``picture``: most refusals are followed by another try and never shown.
    ``found``: it names the place of a part that may turn; ``measured``: that part was measured, and
    is not trusted; ``uncertain``: it would be, were the sigma of its angles smaller. Where that is
    still small beside the motion, ``rough`` is the track.
    """

    def __init__(
        self, sentence: str, draw: Callable[[], Image], measured: bool = False,
        uncertain: bool = False, found: bool = False, rough: Track | None = None,
    ) -> None:  # fmt: skip
        super().__init__(sentence)
        self.draw = draw
        self.found = found or measured
        self.measured = measured
        self.uncertain = uncertain
        self.rough = rough

    @cached_property
    def picture(self) -> Image:
        """What was found (height, width, 3), blue-green-red, with coordinates."""
        return self.draw()
