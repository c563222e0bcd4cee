"""Known disturbances that were recorded and that a model does not have as an input."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from servosight.models.core import Recording, rounded


def unused_disturbances(recordings: Sequence[Recording]) -> list[str]:
    """A sentence for each recording with a known disturbance, which no model has as an input.

    >>> from servosight.models.core import Signals
    >>> t = np.arange(0.0, 1.0, 0.01)
    >>> pushed = Recording("run", t, t, t, t, signals=Signals(t, {"disturbance_N": 20.0 * (t > 1)}))
    >>> unused_disturbances([pushed])
    []
    """
    notes = []
    for one in recordings:
        if one.disturbance_unit is None:
            continue
        largest = float(np.max(np.abs(one.disturbance_at(one.time_s))))
        notes.append(
            f"{one.name}: a known disturbance (up to {rounded(largest)} {one.disturbance_unit}) is "
            f"recorded and not used as an input, so what it moves counts as error of the model"
        )
    return notes
