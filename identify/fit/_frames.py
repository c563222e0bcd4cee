"""Servos that take the command once a frame, as those do that are driven by pulses of 50 Hz.

Rows of the command between two frames never reach the servo: each jump acts later by up to a frame,
and a ramp becomes a stair. A dead time describes the mean of it alone. Found by what a stair with
frames of some usual length, at any time, would take of the residual to first order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from servosight.identify.fit._effects import fit_effects
from servosight.identify.fit._frame_alignment import aligned
from servosight.identify.fit._frame_scene import (
    CommandFrames,
    Found,
    FrameScene,
    alone_in_frames,
    in_frames,
)
from servosight.identify.fit._solution import Solution, polish

_USUAL_S = (
    0.005, 0.008, 0.01, 0.0125, 0.014, 0.015, 1.0 / 60.0, 0.018, 0.02, 0.022, 0.0225, 0.025, 0.03,
    0.04,
)  # fmt: skip
"""Of analogue and digital servos, receivers and autopilots."""
_WINDOW_S = 6.0  # at first: the frames of a length that is off run away over a longer time
_LIKELIEST = 4
_TIMED, _TIMES, _ALIKE = 0.25, 33, 1.2  # of a frame to either side; of the least cost
_ROWS = 1.5  # so many rows of the command at least in a frame
_ALONE = (0.6, 1.6)  # times what the stair would do: more is another effect that looks alike
_LEAST = 0.3  # of the squared residual
_MOST_LEFT = 0.7  # of it in the windows: far more than what may remain of the error
_CLEARER = 1.1  # times the error with the best frames, at least, of those of another length
_MISSES, _REACHED = 2.0, 1.1  # floors: a smaller error than the first is good enough
FRAMES_GAIN = 0.6
"""The error must fall by this share, with all parameters fitted again, before frames are said."""
POSSIBLE_FRAMES_GAIN = 0.25
"""Beside a model that lacks other effects as well, frames that take this share off are possible."""
DEAD_TIME = "dead_time"
"""What all recordings share of their delays."""


@dataclass(frozen=True)
class FramedFit:
    """The frames of a fit's recordings, None where the command acts at each of its rows.

    ``rmse_deg`` is the error of the fit with frames, ``unframed_rmse_deg`` that without, both with
    a dead time.
    """

    frames: tuple[CommandFrames | None, ...]
    rmse_deg: float
    unframed_rmse_deg: float

    def sentences(self, names: Sequence[str], remedy: str) -> tuple[str, ...]:
        """One for each run whose command acts once a frame; ``remedy`` says what is done, with
        {keys} in it. ``names`` (recordings,) are those of the runs, the same for parts of one."""
        found = []
        for name, one in zip(names, self.frames, strict=True):
            if one is None:
                continue
            keys = f"command_frame_s = {one.period_s:.7g} and command_frame_at_s = {one.at_s:.5f}"
            found.append(
                f"{name}: its command acts once every {1e3 * one.period_s:.4g} ms instead of at "
                "each of its rows, as in a servo that is driven by pulses (with such frames the "
                f"rmse is {self.rmse_deg:.3g} deg instead of {self.unframed_rmse_deg:.3g}); "
                f"{remedy.format(keys=keys)}"
            )
        return tuple(dict.fromkeys(found))


def frame_notes(fit: Solution, floor_deg: float) -> tuple[str, ...]:
    """A sentence for each recording of a fit whose command clearly acts once a frame."""
    found = clear_frames(fit, floor_deg)
    names = [one.name for one in fit.problem.recordings]
    remedy = "the fit takes it as it was logged: give {keys} in its recording.toml"
    return () if found is None else found.sentences(names, remedy)


def clear_frames(fit: Solution, floor_deg: float, gain: float = FRAMES_GAIN) -> FramedFit | None:
    """The frames of the recordings of a fit, where they lower its error by the share ``gain`` or
    from twice its floor [deg] to that; else None, as where it is near the floor without them."""
    if fit.rmse_deg <= _MISSES * floor_deg:
        return None
    # Without one, T and xi would stand for what a frame delays in the mean.
    late = _with_dead_time(fit)
    found = _common_frames(late)
    if not any(found):
        return None
    recordings = in_frames(late.problem.recordings, found)
    framed = polish(replace(late.problem, recordings=recordings), [late.outcome.point])
    found, framed = aligned(framed, late.problem.recordings, found)
    done = framed.rmse_deg <= _REACHED * floor_deg and late.rmse_deg > _MISSES * floor_deg
    if framed.rmse_deg > (1.0 - gain) * late.rmse_deg and not done:
        return None
    return FramedFit(found, framed.rmse_deg, late.rmse_deg)


def _with_dead_time(fit: Solution) -> Solution:
    """The fit with a dead time as well, where the catalogue has one."""
    problem = fit.problem
    known = [effect.id for effect in problem.plant.layout.effects]
    if DEAD_TIME in problem.effects or DEAD_TIME not in known:
        return fit
    chosen = tuple(one for one in known if one == DEAD_TIME or one in problem.effects)
    return fit_effects(replace(problem, effects=chosen), fit)


def _common_frames(fit: Solution) -> tuple[CommandFrames | None, ...]:
    """The frames of each recording, of the length with which all are fitted best, where they are
    clear: to first order several may take nearly as much."""
    recordings = fit.problem.recordings
    rows_s = {
        r: float(np.median(np.diff(one.command_time_s)))
        for r, one in enumerate(recordings)
        if np.ptp(one.command_deg) > 0.0
    }
    # Commands with coarser rows keep them, as those of which the frames are known.
    fine_s = _ROWS * min(rows_s.values(), default=np.inf)
    moving = [r for r, row_s in rows_s.items() if row_s < fine_s]
    usual = [one for one in _USUAL_S if one > _ROWS * max((rows_s[r] for r in moving), default=1.0)]
    if not usual:
        return (None,) * len(recordings)
    wholes = {r: FrameScene.of(fit, r) for r in moving}
    windows = {r: one.within(_WINDOW_S) for r, one in wholes.items()}
    rough = _rough(windows, usual)
    if not rough:
        return (None,) * len(recordings)
    likely = {
        length
        for r in moving
        for length in sorted(usual, key=lambda one: rough[r, one][0])[-_LIKELIEST:]
    }
    fine = {
        (r, length): wholes[r].best(wholes[r].around(rough[r, length][2], windows[r]))
        for r in moving
        for length in likely
    }
    errors = {
        length: sum(_framed_cost(fit, r, fine[r, length][2]) for r in moving) for length in likely
    }
    best, *others = sorted(likely, key=lambda one: errors[one])
    if others and errors[others[0]] < _CLEARER**2 * errors[best]:
        return (None,) * len(recordings)
    found: list[CommandFrames | None] = [None] * len(recordings)
    for r in moving:
        share, size, frames = fine[r, best]
        if share > _LEAST and _ALONE[0] < size < _ALONE[1]:
            found[r] = _timed(fit, r, frames)
    return tuple(found)


def _rough(
    windows: Mapping[int, FrameScene], usual: Sequence[float]
) -> dict[tuple[int, float], Found]:
    """The best frames of each usual length in a window of each recording, (recording, length).

    Empty where the recordings with the largest errors show already that frames leave too much.
    """
    squares = {r: float(one.left @ one.left) for r, one in windows.items()}
    rough: dict[tuple[int, float], Found] = {}
    left = 0.0
    for r in sorted(windows, key=lambda r: -squares[r]):
        own = {(r, one): windows[r].best(windows[r].anywhere(one)) for one in usual}
        rough |= own
        left += squares[r] * (1.0 - max(share for share, *_ in own.values()))
        if left > _MOST_LEFT * sum(squares.values()):
            return {}
    return rough


def _timed(fit: Solution, r: int, frames: CommandFrames) -> CommandFrames:
    """The frames in the middle of the times with which the recording is fitted as well as it can.

    A frame takes the same rows over up to a row's length, and the dead time makes up for the rest:
    at the end of that another sample's frame might take the next row.
    """
    away_s = _TIMED * frames.period_s * np.linspace(-1.0, 1.0, _TIMES)
    tried = [replace(frames, at_s=frames.at_s + one) for one in away_s.tolist()]
    costs = np.array([_framed_cost(fit, r, one) for one in tried])
    alike = costs < _ALIKE * costs.min()
    first = last = int(np.argmin(costs))
    while first > 0 and alike[first - 1]:
        first -= 1
    while last < _TIMES - 1 and alike[last + 1]:
        last += 1
    return replace(frames, at_s=0.5 * (tried[first].at_s + tried[last].at_s))


def _framed_cost(fit: Solution, r: int, frames: CommandFrames) -> float:
    """The cost of the model fitted to that recording alone, with these frames [deg^2]."""
    alone, point = alone_in_frames(fit, r, fit.problem.recordings[r], frames)
    return float(polish(alone, [point]).outcome.cost)
