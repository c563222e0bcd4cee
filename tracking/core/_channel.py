"""What of a picture is measured: its grey, or how its colour differs from that."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.models.core import Image, Single

NEUTRAL = 128.0
"""The level of a difference of colour where there is no colour."""


@dataclass(frozen=True, kw_only=True)
class Channel:
    """A weighted sum of a picture's components: its grey, and by how much its blue (Cb) and its red
    (Cr) differ from that, as ITU-R BT.601 has them.

    >>> LUMA
    Channel(luma=1.0, cb=0.0, cr=0.0)
    """

    luma: float = 0.0
    cb: float = 0.0
    cr: float = 0.0

    @property
    def grain(self) -> int:
        """Pixels along a side that share one sample: cameras and codecs halve the size of colour.

        >>> LUMA.grain, Channel(cr=1.0).grain
        (1, 2)
        """
        return 1 if self.luma else 2

    @property
    def words(self) -> str:
        """As it stands in a sentence.

        >>> Channel(cb=-0.6, cr=0.8).words
        'colour (-0.60 Cb + 0.80 Cr)'
        """
        if self.luma:
            return "grey"
        sign = "-" if self.cr < 0.0 else "+"
        return f"colour ({self.cb:.2f} Cb {sign} {abs(self.cr):.2f} Cr)"

    def mixed(self, cb: Image | Single, cr: Image | Single) -> Single:
        """Its sum of two differences of colour, about the level where there is none.

        >>> Channel(cb=0.6, cr=0.8).mixed(np.full((1, 1), 138.0), np.full((1, 1), 118.0))
        array([[126.]], dtype=float32)
        """
        away = self.cb * (cb - NEUTRAL) + self.cr * (cr - NEUTRAL)
        return np.asarray(NEUTRAL + away, np.float32)


LUMA = Channel(luma=1.0)
