"""What recordings can show at all: known disturbances, and what lies before the measured angle."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from servosight.models.core import InputError, Recording, column_map, rounded
from servosight.models.effects import Effect, Place
from servosight.models.plant import Plant


class Offered(dict[str, Effect]):
    """The effects that recordings can show at all, on the plant of the whole catalogue.

    One kernel is then compiled, whatever the recordings hold.
    """

    def __init__(
        self,
        catalogue: Mapping[str, Effect],
        recordings: Sequence[Recording],
        wanted: Sequence[str] = (),
    ) -> None:
        pushed = any(one.disturbance_unit is not None for one in recordings)
        hidden = hidden_places(recordings)
        super().__init__(
            {
                name: one
                for name, one in catalogue.items()
                if (pushed or not one.needs_disturbance)
                and (one.place not in hidden or name in wanted)
            }
        )
        self.whole = catalogue

    @property
    def plant(self) -> Plant:
        """What ``Plant.of`` returns for this catalogue."""
        return Plant.of(self.whole)


def hidden_places(recordings: Sequence[Recording]) -> frozenset[Place]:
    """Where effects act that none of the recordings shows, since its angle is measured before them.

    The horn lies before the linkage. The servo's loop is closed on its own sensor's reading, so an
    error of that sensor is in the surface's angle and not in the reading.

    >>> t = np.arange(0.0, 1.0, 0.01)
    >>> sorted(one.name for one in hidden_places([Recording("run", t, t, t, t, side="sensor")]))
    ['FEEDBACK', 'TRANSMISSION']
    """
    sides = {one.side for one in recordings}
    if "surface" in sides:
        return frozenset()
    return frozenset({Place.TRANSMISSION} | (set() if "horn" in sides else {Place.FEEDBACK}))


def offered(
    catalogue: Mapping[str, Effect],
    recordings: Sequence[Recording],
    wanted: Sequence[str] = (),
) -> Mapping[str, Effect]:
    """``catalogue`` without effects that the recordings cannot show.

    These are effects of a known disturbance where no recording has one, and effects behind the
    angle that was measured (:func:`hidden_places`) and are not ``wanted``. InputError where one of
    the former is.

    >>> from servosight.models.effects import catalogue
    >>> t = np.arange(0.0, 1.0, 0.01)
    >>> "known_disturbance" in offered(catalogue(), [Recording("run", t, t, t, t)])
    False
    """
    found = Offered(catalogue, recordings, wanted)
    for name in wanted:
        if name in catalogue and name not in found:
            raise InputError(
                f"effect {name} acts by a known disturbance, and none of the recordings has one, "
                f"expected a column disturbance_UNIT in signals.csv; import one with "
                f"{column_map('disturbance', 'COLUMN:UNIT')}, or leave the effect out"
            )
    return catalogue if len(found) == len(catalogue) else found


def unused_disturbances(
    recordings: Sequence[Recording],
    effects: Sequence[str] = (),
    catalogue: Mapping[str, Effect] | None = None,
) -> list[str]:
    """A sentence for each recording with a known disturbance that none of ``effects`` takes.

    >>> from servosight.models.core import Signals
    >>> t = np.arange(0.0, 1.0, 0.01)
    >>> pushed = Recording("run", t, t, t, t, signals=Signals(t, {"disturbance_N": 20 * (t > 0.5)}))
    >>> unused_disturbances([pushed])[0][:44]
    'run: a known disturbance (up to 20.0 N) is r'
    """
    known = {} if catalogue is None else catalogue
    if any(known[name].needs_disturbance for name in effects if name in known):
        return []
    takers = [name for name, one in known.items() if one.needs_disturbance]
    way = f"; the effect {takers[0]} takes it as one" if takers else ""
    notes = []
    for one in recordings:
        if one.disturbance_unit is None or one.side == "horn":
            continue
        largest = float(np.max(np.abs(one.disturbance_rows[1])))
        notes.append(
            f"{one.name}: a known disturbance (up to {rounded(largest)} {one.disturbance_unit}) is "
            f"recorded and not used as an input, so what it moves counts as error of the model{way}"
        )
    return notes
