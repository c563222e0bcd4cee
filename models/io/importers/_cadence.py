"""How evenly a log's rows follow each other: long gaps, bursts, and stamps that several share."""

from __future__ import annotations

import numpy as np

from servosight.models.io.tables import Series, several

LONGEST_GAP = 10.0
"""In usual intervals; and at least ``SHORTEST_GAP_S``."""
SHORTEST_GAP_S = 0.1
_AT_ONCE = 0.2
"""The share of the mean interval within which a row of a burst follows the one before."""
_MOST_AT_ONCE = 0.4
"""Of a jittered clock's rows fewer follow that soon; of bursts of two it is half of them."""
_MOST_SHARED = 0.5


def cadence_notes(time: Series, own_command: bool) -> list[str]:
    """What stamps that rise say against the log; ``own_command``: the command has its own rows.

    A gap matters only where the command is missing in it, too.
    """
    steps_s = np.diff(time.values)
    usual_s = float(np.median(steps_s))
    gaps = (steps_s > LONGEST_GAP * usual_s) & (steps_s > SHORTEST_GAP_S)
    notes = []
    if np.any(gaps) and not own_command:
        longest = int(np.argmax(steps_s))
        notes.append(
            f"{time.path}: between {time.word} {time.rows[longest]} and {time.word} "
            f"{time.rows[longest + 1]} the log has no {several(time.word)} for "
            f"{steps_s[longest]:.3g} s{_more(int(np.sum(gaps)))}; the command before holds on "
            f"there, so cut the log there if the clock was set or the servo was moved meanwhile"
        )
    mean_s = float(np.mean(steps_s[~gaps]))
    at_once = float(np.mean(steps_s[~gaps] < _AT_ONCE * mean_s))
    if at_once > _MOST_AT_ONCE:
        notes.append(
            f"{time.path}: {100.0 * at_once:.0f} % of the {several(time.word)} follow the one "
            f"before within a fifth of the mean interval of {mean_s:.3g} s, so that {time.name} "
            f"says when they arrived in bursts and not when the angle was measured; map the clock "
            f"of the device that measures, or stamp the samples there"
        )
    return notes


def stamp_sigma_s(time: Series) -> float:
    """Standard deviation [s] of when the samples of one stamp were taken; 0 where few share one.

    They are spread evenly over the tick of the clock.
    """
    steps_s = np.diff(time.values)
    if not steps_s.size or np.mean(steps_s == 0.0) < _MOST_SHARED or not np.any(steps_s > 0.0):
        return 0.0
    return float(f"{np.median(steps_s[steps_s > 0.0]) / np.sqrt(12.0):.3g}")


def _more(count: int) -> str:
    return f", and {count - 1:,} more gaps" if count > 1 else ""
