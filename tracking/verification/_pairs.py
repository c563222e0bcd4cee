"""Two frames beside each other: by which angle does what changes between them turn?

Neither the part's learnt picture nor its shape nor the background takes part: what differs in one
frame is turned until it lies on the other, both places within what differs. Angles that are too
small, because some of the part was taken for background, agree with their own model and not with
this.
"""

from __future__ import annotations

from typing import Any, Protocol

import cv2
import numpy as np

from servosight.models.core import Array, Mask, Single
from servosight.tracking.core import Index, known_median
from servosight.tracking.verification._turning import PolarView

_PAIRS = 24
_SIGMAS, _LEAST_STEP = 4.0, 5.0
_LEAST_CELLS = 30
_LEAST_TURN_PX = 1.0
_OTHER = 0.5  # times the turn: what is nearer is an angle that is too large or too small
_NEARLY = 0.6


class Claim(Protocol):
    """What a track says of an angle [rad]; (rows, columns) on the raster each."""

    def picture(self, angle_rad: float) -> Single:
        """The turned part over its background."""

    def cover_at(self, angle_rad: float) -> Single:
        """1 on the part."""


def smallest_change(away: Single) -> float:
    """The smallest difference of grey levels that is no noise, by differences of pictures from
    their median, most of which are noise."""
    return _SIGMAS * 1.4826 * float(np.median(np.abs(away))) + _LEAST_STEP


def pairs_apart(angle_rad: Array) -> Array:
    """Frames (pairs, 2) by number, from the lower and the upper half of the angles (n,)."""
    order = np.argsort(angle_rad)
    half = len(order) // 2
    count = min(_PAIRS, half)
    steps = (np.arange(count) * half) // max(count, 1)
    return np.stack([order[steps], order[half + steps]], 1)


def turn_between(
    view: PolarView, first: Single, second: Single, swept: Mask, step: float
) -> tuple[Array, Array] | None:
    """By how much a turn of what changes from the first to the second frame explains the second
    one, and turned back the first one, and the angles [rad], (columns,) each; None where hardly
    anything changes.

    Frames (rows, columns) and ``swept``, where the part passes, on the raster; ``step`` is the
    smallest change.
    """
    differs = cv2.blur((np.abs(first - second) > step).astype(np.float32), (3, 3)) > 0.5
    template = differs & swept
    if template.sum() < _LEAST_CELLS:
        return None
    # Onto what differs alone: the background that the part is about to cover is turned with it,
    # and before clutter that would count more than a part that hardly stands out. Both ways, since
    # else background turned onto what the part uncovers may explain more than the part itself.
    cover = template.astype(np.float32)
    there, back = (np.where(template, one, np.float32(np.nan)) for one in (second, first))
    angles = view.angles()
    gain = view.gains(there, first, first, cover)
    return gain + view.gains(back, second, second, cover)[_backwards(view)], angles


def _backwards(view: PolarView) -> Index:
    """Where the gains of the opposite turns lie (columns,)."""
    return np.asarray((2 * (view.columns // 2) - np.arange(view.columns)) % view.columns, np.intp)


def turn_of_part(
    view: PolarView, first: Single, second: Single, there: Single, back: Single
) -> tuple[Array, Array]:
    """As ``turn_between``, of all that the part covers in the first frame, ``there``, and in the
    second one, ``back``; (rows, columns) each."""
    gain = view.gains(second, first, first, there)
    return gain + view.gains(first, second, second, back)[_backwards(view)], view.angles()


def pair_agreement(
    view: PolarView, frames: Single, angle_rad: Array, swept: Mask, claim: Claim,
    near_rad: float, as_good: float,
) -> float:  # fmt: skip
    """Share of pairs of frames (n, height, width) whose turn is that of their angles (n,).

    ``claim`` is what an angle is said to show, ``near_rad`` the tolerance, ``as_good`` the share of
    the best gain that the angles must reach. 1 where no pair changes enough to tell; nor does one
    tell that by what is claimed looks the same.

    Of a plain plate that turns by less than its own width, what differs is one edge of it in the
    first frame and the other edge in the second one, and these are a width apart. Where another
    turn explains a pair better, which by what is claimed would explain nearly as much, all that the
    part covers is turned instead.
    """
    away = (frames - known_median(frames))[:, ::2, ::2]
    step = smallest_change(away)
    reached = np.nan_to_num(view.of(swept.astype(np.float32), nearest=True)) > 0
    agreed = []
    for one, other in pairs_apart(angle_rad):
        ends = float(angle_rad[one]), float(angle_rad[other])
        turn_rad = ends[1] - ends[0]
        if abs(turn_rad) * view.radius_px[-1] < _LEAST_TURN_PX:
            continue  # of a part at rest, what differs is noise
        first, second = view.of(frames[one]), view.of(frames[other])
        seen = turn_between(view, first, second, reached, step)
        if seen is None:
            continue
        best_rad = float(seen[1][int(np.argmax(seen[0]))])
        same = _agrees(seen, turn_rad, near_rad, as_good)
        if not same and _apart(best_rad, turn_rad) > _OTHER * abs(turn_rad):
            said = turn_between(view, claim.picture(ends[0]), claim.picture(ends[1]), reached, step)
            if said is None:
                continue  # a spoke where another was: what changes is something else, as a hand
            if _largest_near(said, best_rad, near_rad) >= _NEARLY * _largest_near(
                said, turn_rad, near_rad
            ):
                whole = turn_of_part(
                    view, first, second, claim.cover_at(ends[0]), claim.cover_at(ends[1])
                )
                same = _agrees(whole, turn_rad, near_rad, as_good)
        agreed.append(same)
    return float(np.mean(agreed)) if agreed else 1.0


def _agrees(found: tuple[Array, Array], turn_rad: float, near_rad: float, as_good: float) -> bool:
    """Whether a turn [rad] explains nearly as much as the best one; gains and angles (columns,)."""
    best = float(found[0].max())
    return best > 0.0 and _largest_near(found, turn_rad, near_rad) >= as_good * best


def _largest_near(found: tuple[Array, Array], angle_rad: float, near_rad: float) -> float:
    """The largest gain as near an angle [rad] as that; gains and angles (columns,)."""
    gain, angles = found
    return float(gain[_apart(angles, angle_rad) <= near_rad].max())


def _apart(first_rad: Any, second_rad: float) -> Any:
    """By how much angles [rad] differ."""
    return np.abs(np.angle(np.exp(1j * (first_rad - second_rad))))
