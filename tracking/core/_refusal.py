"""A video that cannot be tracked, with a picture of what was found in it."""

from __future__ import annotations

from servosight.models.core import Image, InputError


class TrackRefused(InputError):
    """A video in which no angle could be measured that the frames confirm.

    ``picture`` (height, width, 3), blue-green-red, shows what was found, with coordinates.
    """

    def __init__(self, sentence: str, picture: Image) -> None:
        super().__init__(sentence)
        self.picture = picture
