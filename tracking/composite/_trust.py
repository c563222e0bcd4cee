"""Is a part measured well enough to be returned, beyond what the frames confirm?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array
from servosight.tracking.composite.model import PoseFit


@dataclass(frozen=True, kw_only=True)
class TrustLimits:
    """What a part must reach to be returned.

    Attributes:
        largest_apart_deg: rms difference of its angles from those found without a pivot, of a part
            that the user points at.
        largest_apart_share: the same as a share of the motion, where that is more: what swings
            through 260 deg turns, if 1 deg of that is uncertain.
        largest_apart_found_deg, largest_apart_found_share: both for one that nobody points at,
            which may be a part and its shadow about a point between their pivots. Of 46 composed
            clips whose part turns, two had more: 0.37 % and 0.98 % of the motion, neither of the
            track that was returned at last, and a bar nearly as light as its background has 0.11
            deg, 0.40 %. Six rendered parts that were measured with their shadows, and wrong by 1.6
            to 14 deg, had 0.15 to 0.43 deg, 0.34 to 1.5 %.
        largest_apart_of_motion: the same where the motion is small: what changes by more of it
            slides. On 39 composed clips parts that turned changed by 1.2 % at most, a stick seen in
            part, thought to turn about another place, by 12 %.
        largest_sigma_deg: median sigma of its angles; 95 % of the frames are then within half a
            degree. Not asked of a part that the user points at. Of the clips in
            docs/measured/wild.md, 0.3 deg admits two with 0.25 deg rms, and two with 0.37 and 0.86.
        largest_sigma_share: the same as a share of the motion (``swept_deg``), where that is more:
            of an arm that swings through 250 deg, 0.6 deg is as much worth as 0.05 deg of 20 deg.
        largest_rough_share: sigma as a share of the motion up to which a track of which
            nothing better is known is returned all the same, with a note.
        largest_rough_doubt_px: the pivot's sigma in sampled pictures up to which that is done. On
            composed clips parts found had 0.02 to 0.6 px, and three that were none 1.2 to 1.8.
        least_measured: share of a sampled picture's change that it explains to be measured at all;
            whether the frames confirm it is asked afterwards.
        least_explained: the same to be taken before parts that are looked for otherwise, else a
            hand or a shadow is as likely; and share of what it covers that it explains better than
            the background, in the worst third of its angles. Neither is asked of a part that the
            user points at.
    """

    largest_apart_deg: float = 0.5
    largest_apart_share: float = 1.0 / 200.0
    largest_apart_found_deg: float = 0.125
    largest_apart_found_share: float = 1.0 / 300.0
    largest_apart_of_motion: float = 1.0 / 25.0
    largest_sigma_deg: float = 0.25
    largest_sigma_share: float = 1.0 / 400.0
    largest_rough_share: float = 1.0 / 40.0
    largest_rough_doubt_px: float = 1.0
    least_measured: float = 0.5
    least_explained: float = 0.65

    def most_apart_deg(self, moved_deg: float, pointed: bool) -> float:
        """The largest rms change [deg] without a pivot of a part that moved by ``moved_deg``.

        >>> [TrustLimits().most_apart_deg(moved, pointed=True) for moved in (5.0, 40.0, 240.0)]
        [0.2, 0.5, 1.2]
        >>> [TrustLimits().most_apart_deg(moved, pointed=False) for moved in (5.0, 40.0, 240.0)]
        [0.125, 0.133333, 0.8]
        """
        least_deg, share = self.largest_apart_found_deg, self.largest_apart_found_share
        if pointed:
            least_deg, share = self.largest_apart_deg, self.largest_apart_share
        usual = max(least_deg, round(share * moved_deg, 6))
        return min(usual, round(self.largest_apart_of_motion * moved_deg, 6))

    def most_deg(self, moved_deg: float) -> float:
        """The largest median sigma [deg] of a part that moved by ``moved_deg``.

        >>> TrustLimits().most_deg(40.0), TrustLimits().most_deg(240.0)
        (0.25, 0.6)
        """
        return max(self.largest_sigma_deg, round(self.largest_sigma_share * moved_deg, 6))


TRUST = TrustLimits()


def uncertain(angle_deg: Array, sigma_deg: Array, limits: TrustLimits = TRUST) -> str | None:
    """That a part's angles (found,) have too large a sigma, as the end of a sentence that begins
    with it; None where they have not."""
    usual_deg, most_deg = float(np.median(sigma_deg)), limits.most_deg(swept_deg(angle_deg))
    if usual_deg <= most_deg:
        return None
    return f"is measured with a sigma of {usual_deg:.3g} deg; expected {most_deg:.3g} deg at most"


def rough_enough(
    angle_deg: Array, sigma_deg: Array, doubt_px: float, limits: TrustLimits = TRUST
) -> bool:
    """Whether a part's angles (found,) about a pivot with a sigma of ``doubt_px`` are worth
    returning with a note, however uncertain.

    >>> rough_enough(np.linspace(0.0, 40.0, 81), np.full(81, 0.9), 0.2)
    True
    """
    most_deg = limits.largest_rough_share * swept_deg(angle_deg)
    return float(np.median(sigma_deg)) <= most_deg and doubt_px <= limits.largest_rough_doubt_px


def swept_deg(angle_deg: Array) -> float:
    """The range of angles (found,), without the widest gap in which there is none; a turn at most.

    Someone at the border who looks alike at two angles 90 deg apart does not turn through them, and
    no more turns make a wrong angle less wrong.

    >>> swept_deg(np.array([0.0, 2.0, 4.0, 94.0, 96.0]))
    6.0
    """
    ordered = np.sort(angle_deg)
    swept = float(ordered[-1] - ordered[0] - np.diff(ordered).max(initial=0.0))
    return min(swept, 360.0)


def rough_note(angle_deg: Array, sigma_deg: Array) -> str:
    """That a part's angles (found,) are uncertain, as a note."""
    return (
        f"all angles are uncertain by {np.median(sigma_deg):.2g} deg (one sigma) of the "
        f"{np.ptp(angle_deg):.3g} deg that the part turns: film it larger, sharper, without "
        "shadows and along the axis, and give the exposure, where that is too much"
    )


def distrust(
    apart_deg: float, sigma_deg: Array, fits: Sequence[PoseFit | None], pointed: bool,
    limits: TrustLimits = TRUST,
) -> str | None:  # fmt: skip
    """Why a part is not returned, as the end of a sentence that begins with it; None if it is.

    ``sigma_deg`` (found,) are those of the frames in which it was found.
    """
    angle_deg = np.rad2deg([fit.angle_rad for fit in fits if fit is not None])
    if apart_deg > limits.most_apart_deg(swept_deg(angle_deg), pointed):
        return (
            f"turns by angles that differ by {apart_deg:.2g} deg rms from those found without a "
            "pivot; expected a part that turns about one point, without its shadow"
        )
    if pointed:
        return None
    why = uncertain(angle_deg, sigma_deg, limits)
    if why is not None:
        return f"{why}, film it larger, without shadows"
    least = worst_third(fits)
    if least < limits.least_explained:
        return (
            f"explains only {least:.0%} of what it covers at some of its angles; expected "
            f"{limits.least_explained:.0%} at all of them, as of a rigid part in full view"
        )
    return None


def worst_third(fits: Sequence[PoseFit | None]) -> float:
    """The smallest median share explained, of three thirds of the frames by their angle."""
    pairs = np.array([(fit.angle_rad, fit.explained) for fit in fits if fit is not None])
    ordered = pairs[np.argsort(pairs[:, 0]), 1]
    return min(float(np.median(third)) for third in np.array_split(ordered, 3))
