"""Exposure and readout of an unknown camera from what is left of its pictures, with their sigma.

The motion blur of a picture is proportional to the exposure, its shear to the readout time. Both
change the residuals of a learnt part, so the pair with the smallest residuals is the camera's: one
number each for all frames. A picture read from its last row up has a readout below zero.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from servosight.models.core import Array
from servosight.tracking.calibration.shutter._likely import LikelyReadout, likely_share
from servosight.tracking.core import Index, Shutter, Shutters

LEAST = 8  # frames
_FASTER = 1.2  # times the speed of those from which the part is learnt
_STEPS = 8  # of a frame time, at first
_FINER = 3
_AROUND = 2
_ROUNDS = 8  # of the finer steps, three steps at most each
_SURE, _UNLIKELY = 0.9, 0.25  # probability of a rolling shutter
_TIMES, _EXPOSURE_AT_LEAST, _READOUT_AT_LEAST = 2.0, 0.025, 0.02
_LIKE = 0.005  # of the residuals: by so much the best value may leave more
# By so much the mean square width of the blur in fast pictures and in those that the part is
# learnt from may differ otherwise, as of a codec, a shadow or a focus that changes: 0.12 (rms) in
# 17 composed clips of moderate speed.
_WIDTH_PX2 = 0.15
# A blur as of nearly a whole frame time, where that is below some pixels, has such a cause: in
# three clips that were exposed for 0.15 to 0.4 of it. So has such a shear, in one that was read in
# 0.19 of it.
_WHOLE, _SLOW_PX = 0.94, 6.0
# Blur and shear as of a whole frame time both have another cause at any speed: shake and tilt of a
# camera that exposed for half of it, without a readout, were taken for 0.93 and 0.99 of it.
_BOTH = 0.9
_ARM = 0.7  # of the largest radius: the mean distance of what shows the blur
_UNKNOWN = 1.0 / np.sqrt(12.0)  # of a frame time: uniform up to it

Left = Callable[[Shutter], Array]


def faster(speed: Array, learnt: float) -> Index:
    """Which pictures with these speeds (n,) are faster than those that the part was learnt from;
    all where too few are."""
    which = np.flatnonzero(np.abs(speed) > _FASTER * learnt)
    return which if which.size >= LEAST else np.arange(speed.size)


def usual_speed(speed: Array) -> float:
    """The speed with the mean blur of several: widths add in squares."""
    return float(np.sqrt(np.mean(np.square(speed))))


def further_speed(speed: float, learnt: float) -> float:
    """The speed that adds as much blur to that of a part learnt at a speed ``learnt`` as this one
    has: widths add in squares.

    >>> further_speed(-5.0, 3.0), further_speed(2.0, 3.0)
    (4.0, 0.0)
    """
    return float(np.sqrt(max(speed**2 - learnt**2, 0.0)))


def further_px(speed: Array, learnt: float, frame_s: float, radius_px: float) -> float:
    """How far what shows the blur moves from frame to frame [px], beyond pictures of the speed
    ``learnt``, in pictures with these speeds (n,) [rad/s] of a part with this largest radius.

    >>> round(further_px(np.array([5.0, -5.0]), 3.0, 0.01, 100.0), 3)
    2.8
    """
    further = float(np.median([further_speed(one, learnt) for one in speed.tolist()]))
    return frame_s * further * _ARM * radius_px


def found_shutters(
    left: Left, rough: Left, frame_s: float, pace_px: float, by_rows: bool = True,
    alike: float = 1.0,
) -> Shutters:  # fmt: skip
    """The shutters with the least squared residuals ``left`` (frames,) of the frames, and sigma.

    ``rough`` are less exact ones, and cheaper; ``frame_s`` is the time from frame to frame, in
    which what tells the blur moves by ``pace_px`` further than in the pictures that the part was
    learnt from. Where the sensor is not read ``by_rows`` of the picture, shear tells no readout.
    What all frames have in common, at any speed, is ``alike`` a readout (0 to 1).
    """
    found = (best_shutter if by_rows else best_exposure)(left, frame_s, rough)
    share = found.shutter.exposure_s / frame_s
    slow = pace_px < _SLOW_PX
    both = by_rows and min(share, abs(found.shutter.readout_s) / frame_s) >= _BOTH
    if both or (slow and share >= _WHOLE):
        return unknown_shutters(frame_s)
    scatter = _TIMES * found.exposure_doubt_s / frame_s
    opens = _norm(scatter, _EXPOSURE_AT_LEAST, found.exposure_like)
    share, opens = likely_share(share, opens, 12.0 * _WIDTH_PX2 / max(pace_px, 1e-3) ** 2)
    rolls = found.shutter.readout_s / frame_s
    scatter = _TIMES * found.readout_doubt_s / frame_s
    doubt = _norm(scatter, _READOUT_AT_LEAST, alike * found.readout_like)
    if slow and abs(rolls) >= _WHOLE:
        rolls, doubt = 0.0, np.inf
    likely = LikelyReadout.of(rolls, doubt)
    if by_rows and likely.rolls >= _SURE:
        upwards = " from the last row up" if rolls < 0.0 else ""
        shear = f"readout {1e3 * frame_s * abs(rolls):.2g} ms{upwards}, found from shear,"
        return _noted(frame_s, (share, opens), (rolls, doubt), 0.0, shear)
    return _unseen(frame_s, (share, opens), likely)


def unknown_shutters(frame_s: float) -> Shutters:
    """Those of a camera of which nothing is known but the time from frame to frame."""
    return _unseen(frame_s, likely_share(0.0, np.inf, 0.0), LikelyReadout.of(0.0, np.inf))


def _norm(*parts: float) -> float:
    return float(np.linalg.norm(parts))


def _unseen(frame_s: float, opens: tuple[float, float], likely: LikelyReadout) -> Shutters:
    """Shutters with a readout that does not show: rows are not corrected."""
    shear = f"readout {1e3 * frame_s * likely.size:.2g} ms, the mean of what shear leaves open,"
    if likely.rolls < _UNLIKELY:
        shear = "no rolling shutter, which no shear shows,"
    return _noted(frame_s, opens, (0.0, likely.rms), likely.size, shear)


def _noted(
    frame_s: float, opens: tuple[float, float], rolls: tuple[float, float], likely: float,
    shear: str,
) -> Shutters:  # fmt: skip
    """Shutters by exposure, readout and their sigma as shares of the frame time."""
    sigma = float(np.sqrt(rolls[1] ** 2 - likely**2))
    note = (
        "exposure and readout of the camera are not given: taken as exposure "
        f"{1e3 * frame_s * opens[0]:.2g} ms, found from motion blur, with a sigma of "
        f"{1e3 * frame_s * opens[1]:.2g} ms, and {shear} with a sigma of "
        f"{1e3 * frame_s * sigma:.2g} ms, which sigma includes: values given in [camera] of "
        "recording.toml are more accurate"
    )
    return Shutters(
        np.array([frame_s * opens[0]]), frame_s * rolls[0], frame_s * rolls[1], note,
        frame_s * opens[1], frame_s * likely,
    )  # fmt: skip


@dataclass(frozen=True)
class ShutterEstimate:
    """The shutter of least residual; sigma of exposure and readout from the scatter alone, that of
    a value which may be anything within a frame time where no least residual is found; and by what
    share of the frame time both differ where the residuals are nearly as small."""

    shutter: Shutter
    exposure_doubt_s: float
    readout_doubt_s: float
    exposure_like: float
    readout_like: float


def best_shutter(left: Left, frame_s: float, rough: Left) -> ShutterEstimate:
    """The shutter with the least squared residuals ``left`` (frames,) of the frames.

    ``rough`` are less exact ones, and cheaper, for the first steps. Exposure and readout in turn,
    over a whole frame time and then in finer steps until both converge, to within what either
    scatters by: a wrong exposure can look like a readout. Where they do not converge, as along a
    valley without a lowest place, neither is known.
    """

    def readout(at_s: Array, opens_s: float, by: Left = left) -> list[Array]:
        return [by(Shutter(opens_s, s)) for s in at_s.tolist()]

    def exposure(at_s: Array, rolls_s: float, by: Left = left) -> list[Array]:
        return [by(Shutter(s, rolls_s)) for s in at_s.tolist()]

    step_s = frame_s / _STEPS
    coarse: Array = step_s * np.arange(-_STEPS, _STEPS + 1.0)
    by_opens = exposure(coarse[_STEPS:], 0.0, rough)
    opens_s, _ = least_residual(coarse[_STEPS:], by_opens)
    by_rolls = readout(coarse, opens_s, rough)
    rolls_s, _ = least_residual(coarse, by_rolls)
    like = [_like(coarse[_STEPS:] / frame_s, by_opens), _like(coarse / frame_s, by_rolls)]
    for _ in range(_ROUNDS):
        before_s = opens_s, rolls_s
        at_s = _about(opens_s, 0.0, frame_s)
        opens_s, opens_doubt_s = least_residual(at_s, exposure(at_s, rolls_s))
        at_s = _about(rolls_s, -frame_s, frame_s)
        rolls_s, rolls_doubt_s = least_residual(at_s, readout(at_s, opens_s))
        moved_s = np.subtract((opens_s, rolls_s), before_s)
        if _settled(moved_s, (opens_doubt_s, rolls_doubt_s), frame_s):
            return ShutterEstimate(Shutter(opens_s, rolls_s), opens_doubt_s, rolls_doubt_s, *like)
    unknown = _UNKNOWN * frame_s
    return ShutterEstimate(Shutter(opens_s, rolls_s), unknown, unknown, *like)


def best_exposure(left: Left, frame_s: float, rough: Left) -> ShutterEstimate:
    """The exposure alone with the least squared residuals, as :func:`best_shutter` finds it; the
    readout is not known."""
    coarse: Array = frame_s / _STEPS * np.arange(_STEPS + 1.0)
    by_opens = [rough(Shutter(s)) for s in coarse.tolist()]
    opens_s, _ = least_residual(coarse, by_opens)
    like, unknown = _like(coarse / frame_s, by_opens), _UNKNOWN * frame_s
    for _ in range(_ROUNDS):
        before_s = opens_s
        at_s = _about(opens_s, 0.0, frame_s)
        opens_s, doubt_s = least_residual(at_s, [left(Shutter(s)) for s in at_s.tolist()])
        if _settled(opens_s - before_s, doubt_s, frame_s):
            return ShutterEstimate(Shutter(opens_s), doubt_s, unknown, like, 1.0)
    return ShutterEstimate(Shutter(opens_s), unknown, unknown, like, 1.0)


def _settled(moved_s: Array | float, doubt_s: Sequence[float] | float, frame_s: float) -> bool:
    """Whether values moved by less than a finer step, or than they scatter by."""
    return bool(np.all(np.abs(moved_s) < np.maximum(doubt_s, frame_s / _STEPS / _FINER)))


def least_residual(at_s: Array, left: Sequence[Array]) -> tuple[float, float]:
    """The value with the least total of the residuals ``left`` (frames,) at each of ``at_s``, by
    the parabola about the lowest; and its sigma by the jackknife, leaving out one frame after the
    other: residuals that are correlated within a frame count as one."""
    table = _relative(left)
    count = table.shape[1]
    if count < LEAST:
        return 0.0, float(at_s[-1] - at_s[0])
    total = table.sum(1)
    whole = vertex(at_s, total)
    parts = np.array([vertex(at_s, total - column) for column in table.T])
    scatter = (count - 1) / count * float(((parts - parts.mean()) ** 2).sum())
    return whole, float(np.sqrt(scatter))


def _relative(left: Sequence[Array]) -> Array:
    """Residuals (values, frames) relative to each frame's least, of the frames that have all."""
    table = np.array(left)
    table = table[:, np.isfinite(table).all(0)]
    return np.asarray(table / table.min(0, initial=np.inf))


def _like(share: Array, left: Sequence[Array]) -> float:
    """By how much a share differs where the residuals ``left`` (frames,) are nearly as small as the
    least: what pictures have in common that the model does not know, as a shadow, moves it so far.
    By the bend of the residuals about their least; that is one-sided where the least is the last
    value, as of a readout of a whole frame time."""
    table = _relative(left)
    if table.shape[1] < LEAST:
        return 1.0
    total = table.mean(1)
    near, least = _near(total), int(np.argmin(total))
    if least in (0, total.size - 1):
        away = np.square(share[near] - share[least])
        bend = float(away @ (total[near] / total.min() - 1.0) / (away @ away))
    else:
        bend = np.polyfit(share[near], total[near] / total.min(), 2)[0]
    return float(np.sqrt(_LIKE / max(bend, _LIKE)))


def _near(total: Array) -> slice:
    """The values about the least of ``total`` (values,), within them."""
    n = int(np.clip(np.argmin(total), _AROUND, total.size - 1 - _AROUND))
    return slice(n - _AROUND, n + _AROUND + 1)


def vertex(at_s: Array, total: Array) -> float:
    """The minimum of a parabola about the smallest of ``total``, within the values tried."""
    near = _near(total)
    middle, unit = at_s[near][_AROUND], at_s[1] - at_s[0]
    bend, slope, _ = np.polyfit((at_s[near] - middle) / unit, total[near], 2)
    if bend <= 0.0:
        return float(at_s[int(np.argmin(total))])
    return float(np.clip(middle - 0.5 * unit * slope / bend, at_s[0], at_s[-1]))


def _about(value_s: float, low_s: float, high_s: float) -> Array:
    """Finer steps about a value, from ``low_s`` to ``high_s``, a frame time, at most."""
    step = high_s / _STEPS / _FINER
    low = float(np.clip(value_s - 3 * step, low_s, high_s - 6 * step))
    return low + step * np.arange(7.0)
