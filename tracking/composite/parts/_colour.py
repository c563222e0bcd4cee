"""The difference of colour in which what moves contrasts most."""

from __future__ import annotations

import numpy as np

from servosight.models.core import Mask, Single
from servosight.tracking.composite.parts._entering import entering
from servosight.tracking.composite.parts._part import Change
from servosight.tracking.core import Channel


def colour_of(cb: Single, cr: Single, content: Mask) -> Channel | None:
    """The sum of squares 1 of two differences of colour (n, height, width) that changes most; None
    where neither changes.

    The main axis of what changes in both, without what enters the picture: a part that has the grey
    of what lies behind it differs from it in one direction of colour, seldom that of Cb or of Cr.
    ``content`` (height, width) is what is known in all pictures.
    """
    changes = [Change.of(one) for one in (cb, cr)]
    moved = changes[0].moved | changes[1].moved
    moved &= ~(entering(cb, content) | entering(cr, content))
    away = [(one - change.usual)[moved] for one, change in zip((cb, cr), changes, strict=True)]
    if not moved.any():
        return None
    size, axes = np.linalg.eigh(np.array([[float(a @ b) for a in away] for b in away]))
    main = axes[:, int(np.argmax(size))]
    main = main * np.sign(main[np.argmax(np.abs(main))])
    return Channel(cb=round(float(main[0]), 3), cr=round(float(main[1]), 3))
