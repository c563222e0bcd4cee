"""The ratio of surface to horn over the angle, and the play between them, from both angles.

The surface follows a smooth curve of where play leaves it. The curve is a polynomial, whose degree
other stretches of time choose than fit it; its slope is the ratio. Uncertainties account for
stretches of time that differ, and for errors that all angles of a part share.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from servosight.identify.problem import noise_deg
from servosight.identify.transmission._curve import (
    HIGHEST_DEGREE,
    curve,
    degree_of,
    jackknife,
    slopes_of,
    solved,
)
from servosight.identify.transmission._play import driven
from servosight.models.core import (
    Array,
    Estimate,
    Frozen,
    InputError,
    Mask,
    Recording,
    Table,
    axes_of,
    rms,
    uncertain,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FEWEST_SAMPLES = 100
SHOWN = 3.0
"""Play of fewer sigmas is not distinguished from none."""
OF_NOISE = 6.0
"""Nor is play of fewer standard deviations of the horn's noise: a gap that wide smooths noise."""
_MOST = 5_000
"""Most samples on which the gap is sought: a curve through more costs time and changes nothing."""
_GAPS = 41
_ROUNDS = 5
_PLACES = 9
_REACH = 2
"""Number of samples to either side over which motion is judged."""
_INNER = (0.02, 0.98)
"""The ratio is given between these quantiles of the horn's angle: beyond, it is extrapolated."""


@dataclass(frozen=True)
class Transmission(Frozen):
    """What lies between horn and surface.

    ``horn_deg`` (places,) are angles of the horn over its range, ``ratio`` and ``ratio_sigma``
    (places,) the surface's motion over the horn's there [-]. ``play_deg`` is the full width of the
    play, in degrees of the horn, None where none was seen; ``rmse_deg`` what curve and play leave
    of the surface's angle, ``noise_deg`` what the noise of both angles leaves of it, and ``degree``
    the curve's; ``words`` are ratio and play, ``sentence`` all that, in words.
    """

    recording: str
    horn_deg: Array
    ratio: Array
    ratio_sigma: Array
    play_deg: Estimate | None
    rmse_deg: float
    noise_deg: float
    degree: int
    words: str = ""
    sentence: str = ""

    def plot(self, ax: Axes | None = None) -> Axes:
        """The ratio over the horn's angle, with two sigma to either side."""
        axes = axes_of(ax)
        axes.errorbar(self.horn_deg, self.ratio, 2.0 * self.ratio_sigma, fmt="o-", capsize=3.0)
        axes.set_xlabel("angle of the horn [deg]")
        axes.set_ylabel("motion of the surface over that of the horn [-]")
        axes.set_title(self.recording)
        return axes


def transmission(surface: Recording, horn: Recording) -> Transmission:
    """What the two angles of one run tell of the transmission between horn and surface.

    Raises InputError for too few samples, or too little motion.

    >>> t = np.arange(0.0, 8.0, 0.01)
    >>> turned = 20.0 * np.sin(t)
    >>> horn = Recording("run (horn)", t, turned, t, turned, side="horn")
    >>> surface = Recording("run", t, turned, t, 0.8 * turned)
    >>> transmission(surface, horn).ratio.round(3).max()
    np.float64(0.8)
    """
    time_s = surface.time_s
    seen = (time_s >= horn.time_s[0]) & (time_s <= horn.time_s[-1])
    if int(seen.sum()) < FEWEST_SAMPLES:
        raise InputError(
            f"{surface.name}: shows horn and surface together in {int(seen.sum())} samples, "
            f"expected {FEWEST_SAMPLES} or more; record longer"
        )
    angle = np.interp(time_s[seen], horn.time_s, horn.angle_deg)
    noises = noise_deg(surface), noise_deg(horn)
    found = _fitted(surface.name, angle, surface.angle_deg[seen], noises, _shared(surface, horn))
    words = _words(found)
    return replace(
        found,
        words=words,
        sentence=f"{words}; {found.rmse_deg:.2g} deg rms remain, where noise makes "
        f"{found.noise_deg:.2g}",
    )


def transmissions(views: Sequence[Recording]) -> Table[Transmission]:
    """That of each of ``views`` whose horn comes behind it, as far as it moves enough."""
    found = []
    for surface, horn in pairwise(views):
        if horn.side == "horn" and surface.side == "surface":
            with suppress(InputError):
                found.append(transmission(surface, horn))
    return Table(found)


def _shared(surface: Recording, horn: Recording) -> list[Array]:
    """Errors that all angles of a part share, by one sigma each: (2, samples) of horn and surface.

    A pivot that is a little off turns the horn by an error that follows its angle: no residual
    shows it, and the ratio is wrong by it.
    """
    seen = (surface.time_s >= horn.time_s[0]) & (surface.time_s <= horn.time_s[-1])
    time_s = surface.time_s[seen]
    none = np.zeros(time_s.size)
    modes: list[Array] = []
    if horn.shared_deg is not None:
        driver = (np.interp(time_s, horn.time_s, one) for one in horn.shared_deg.T)
        modes += [np.stack([one, none]) for one in driver]
    if surface.shared_deg is not None:
        modes += [np.stack([none, one]) for one in surface.shared_deg[seen].T]
    return modes


def _left(angle: Array, follower: Array, gaps: Array) -> Array:
    """Mean square that the best curve leaves behind each gap, (gaps,) [deg^2]."""
    places, known = driven(angle, gaps)
    found = []
    every = max(follower.size // _MOST, 1)
    for place, good in zip(places[:, ::every], known[:, ::every], strict=True):
        rows = curve(place[good], _range(angle), HIGHEST_DEGREE)
        if rows.shape[0] < FEWEST_SAMPLES:
            found.append(np.inf)
            continue
        wanted = follower[::every][good]
        values = solved(rows, wanted)
        found.append(float(np.mean((wanted - rows @ values) ** 2)))
    return np.array(found)


def _range(angle: Array) -> tuple[float, float]:
    return float(angle.min()), float(angle.max())


def _gap(angle: Array, follower: Array) -> float:
    """The gap with which a curve leaves least, by ever finer grids [deg]."""
    low, high = 0.0, 0.5 * float(np.ptp(angle))
    best = 0.0
    for _ in range(_ROUNDS):
        gaps = np.linspace(low, high, _GAPS)
        best = float(gaps[np.argmin(_left(angle, follower, gaps))])
        step = (high - low) / (_GAPS - 1)
        low, high = max(best - 2.0 * step, 0.0), best + 2.0 * step
    return best


def _pushed(place: Array, known: Mask, noise: float) -> Mask:
    """Samples in clear motion: at rest the horn's noise alone pushes its largest values on."""
    reach = np.abs(place[2 * _REACH :] - place[: -2 * _REACH])
    moving = np.zeros(place.size, dtype=bool)
    moving[_REACH:-_REACH] = reach > OF_NOISE * noise
    return moving & known


def _fitted(
    name: str, angle: Array, follower: Array, noises: tuple[float, float], shared: Sequence[Array]
) -> Transmission:
    """Curve and play, with their covariance; ``noises`` of surface and horn [deg]."""
    noise = noises[1]
    ends = _range(angle)
    gap = _gap(angle, follower)
    step = 1e-3 * max(gap, noise, 1e-6 * (ends[1] - ends[0]))
    (place, wider), known = driven(angle, np.array([gap, gap + step]))
    good = _pushed(place, known[0] & known[1], noise)
    if int(good.sum()) < FEWEST_SAMPLES:
        raise InputError(
            f"{name}: the horn moves clearly in {int(good.sum())} samples, expected "
            f"{FEWEST_SAMPLES} or more; record longer, or more motion"
        )
    place, wider, wanted = place[good], wider[good], follower[good]
    degree = degree_of(place, wanted, ends)
    rows = curve(place, ends, degree)
    values = solved(rows, wanted)
    residuals = wanted - rows @ values
    moved = (curve(wider, ends, degree) - rows) @ values / step
    covariance = jackknife(np.column_stack([rows, moved]), residuals)
    low, high = np.quantile(place, _INNER)
    shown = np.linspace(float(low), float(high), _PLACES)
    slopes = slopes_of(shown, ends, degree)
    variance = np.einsum("ij,jk,ik->i", slopes, covariance[:-1, :-1], slopes)
    finer = solved(curve(place, ends, degree + 2), wanted)
    missing = slopes_of(shown, ends, degree + 2) @ finer - slopes @ values
    ratio = slopes @ values
    off = np.zeros(_PLACES)
    for driver, driven_too in shared:
        (other,), _ = driven(angle + driver, np.array([gap]))
        turned = solved(curve(other[good], ends, degree), wanted + driven_too[good])
        off += (slopes @ turned - ratio) ** 2
    own = float(np.sqrt(covariance[-1, -1]))
    seen = gap > max(SHOWN * own, OF_NOISE * noise)
    return Transmission(
        recording=name,
        horn_deg=shown,
        ratio=ratio,
        ratio_sigma=np.sqrt(variance + missing**2 + off),
        play_deg=Estimate(gap, own, "deg") if seen else None,
        noise_deg=float(np.hypot(noises[0], np.mean(np.abs(slopes @ values)) * noises[1])),
        rmse_deg=rms(residuals),
        degree=degree,
    )


def _words(found: Transmission) -> str:
    """The ratio's range and the play."""
    low, high = int(np.argmin(found.ratio)), int(np.argmax(found.ratio))
    spread = found.ratio[high] - found.ratio[low]
    ends = [
        f"{' ± '.join(uncertain(found.ratio[i], found.ratio_sigma[i]))} times "
        f"(horn at {found.horn_deg[i]:.3g} deg)"
        for i in (low, high)
    ]
    if spread < SHOWN * np.hypot(found.ratio_sigma[low], found.ratio_sigma[high]):
        ends = [ends[0].partition(" (")[0]]
    play = "no play is seen"
    if found.play_deg is not None:
        play = f"play of {' ± '.join(uncertain(found.play_deg.value, found.play_deg.sigma))} deg"
    return f"the surface turns {' to '.join(ends)} as far as the horn; {play}"
