"""Even and odd nonlinear distortion against noise, without any model of the servo.

A periodic command that excites odd harmonics only, and leaves some of these out, is answered by a
linear servo at the excited lines alone, once it has settled. What is at the other lines and
repeats from period to period is distortion; what does not repeat is noise (Pintelon and Schoukens,
System Identification, 2nd ed., 2012, sections 4.3.1 and 4.3.2: the fast method on one phase
realisation). Frames need not fit the period: harmonics are found by least squares.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from servosight.models.core import Array, Complex, InputError, Recording
from servosight.models.excitation import Grid, grid_of

DistortionKind = Literal["excited", "odd", "even"]

CHANCE = 1e-3
"""Distortion is reported where its chance under noise alone is below this."""
FEWEST_PERIODS = 3
"""The first one settles; two separate noise from what repeats."""
_FILL = 0.4
"""Harmonics up to this share of the frames in a period are resolved."""


@dataclass(frozen=True)
class Level:
    """Power at the lines of one kind, as rms over the whole band [deg].

    ``noise_deg`` is the noise of the mean period at the same lines; ``chance`` is how often noise
    alone shows as much (F test with 2 lines and 2 lines (periods - 1) degrees of freedom).
    """

    rms_deg: float
    noise_deg: float
    lines: int
    chance: float

    @property
    def found(self) -> bool:
        """True where it is more than noise."""
        return self.chance < CHANCE


@dataclass(frozen=True)
class Distortion:
    """The spectrum of a settled answer at harmonics of 1 / ``period_s``, by kind of line.

    ``frequency_hz``, ``amplitude_deg`` (peak, of the mean period) and ``sigma_deg`` (of that
    amplitude's real and imaginary part) are (lines,); ``kinds`` says what each line is.
    """

    recording: str
    period_s: float
    periods: int
    frequency_hz: Array
    amplitude_deg: Array
    sigma_deg: Array
    kinds: tuple[DistortionKind, ...]
    response: Level
    odd: Level
    even: Level

    @property
    def sentence(self) -> str:
        """What was found, in words."""
        parts = []
        for level, name, cause in (
            (self.odd, "Odd", "something symmetric such as friction, play, a dead zone or a limit"),
            (self.even, "Even", "something one-sided such as an off-centre load or unequal drive"),
        ):
            if level.found:
                share = 100.0 * level.rms_deg / max(self.response.rms_deg, 1e-12)
                ratio = level.rms_deg / max(level.noise_deg, 1e-12)
                parts.append(
                    f"{name} distortion of {level.rms_deg:.2g} deg rms, {share:.2g} % of the "
                    f"response and {ratio:.3g} times the noise there: {cause}"
                )
            elif level.lines:
                parts.append(f"No {name.lower()} distortion above {level.noise_deg:.2g} deg rms")
        return f"{'. '.join(parts)}."

    def to_json(self) -> dict[str, Any]:
        """Levels and lines."""
        levels = {"response": self.response, "odd": self.odd, "even": self.even}
        return {
            "recording": self.recording,
            "period_s": self.period_s,
            "periods": self.periods,
            "sentence": self.sentence,
            **{
                name: {
                    "rms_deg": level.rms_deg,
                    "noise_deg": level.noise_deg,
                    "lines": level.lines,
                    "found": level.found,
                    "chance": level.chance,
                }
                for name, level in levels.items()
            },
            "lines": [
                {"frequency_hz": f, "amplitude_deg": a, "sigma_deg": s, "kind": kind}
                for f, a, s, kind in zip(
                    self.frequency_hz.tolist(),
                    self.amplitude_deg.tolist(),
                    self.sigma_deg.tolist(),
                    self.kinds,
                    strict=True,
                )
            ],
        }


def distortion(recording: Recording) -> Distortion | None:
    """Distortion in the answer to a periodic odd command; None where the command is none.

    Raises InputError where the command would do, but periods or frames are too few.
    """
    grid = grid_of(recording.command_time_s, recording.command_deg)
    if grid is None:
        return None
    windows = _windows(recording, grid)
    top = max(int(lines[-1]) for lines in (grid.excited, grid.odd, grid.even) if lines.size)
    fewest = min(int(window.sum()) for window in windows)
    if top > _FILL * fewest:
        raise InputError(
            f"{recording.name}: {fewest} frames in a period of {grid.period_s:.4g} s resolve "
            f"{int(_FILL * fewest)} harmonics, expected {top} for this command; film faster or "
            f"lower its highest frequency"
        )
    count = int(min(_FILL * fewest, 3 * top))
    spectra = np.array([_harmonics(recording, window, grid, count) for window in windows])
    mean = spectra.mean(axis=0)
    used = len(windows)
    spread = np.sum(np.abs(spectra - mean) ** 2, axis=0) / (used * (used - 1))
    lines = np.sort(np.concatenate([grid.excited, grid.odd, grid.even]))
    return Distortion(
        recording.name,
        grid.period_s,
        used,
        lines / grid.period_s,
        np.abs(mean[lines - 1]),
        np.sqrt(0.5 * spread[lines - 1]),
        tuple(_kind(int(line), grid) for line in lines),
        _level(mean, spread, grid.excited, used, 1.0),
        # Odd distortion falls on excited lines as well, unseen: as much a line as beside them.
        _level(mean, spread, grid.odd, used, 1.0 + grid.excited.size / max(grid.odd.size, 1)),
        _level(mean, spread, grid.even, used, 1.0),
    )


def _windows(recording: Recording, grid: Grid) -> list[NDArray[np.bool_]]:
    """The whole periods that the angle covers, without the first; (samples,) each."""
    start = float(recording.command_time_s[0])
    index = np.floor((recording.time_s - start) / grid.period_s + 1e-9)
    slack = 2.0 * float(np.median(np.diff(recording.time_s)))
    found = []
    for p in range(1, grid.periods):
        low, high = start + p * grid.period_s, start + (p + 1) * grid.period_s
        if recording.time_s[0] <= low + slack and recording.time_s[-1] >= high - slack:
            found.append(index == p)
    if len(found) < FEWEST_PERIODS - 1:
        raise InputError(
            f"{recording.name}: the angle covers {len(found)} settled periods of "
            f"{grid.period_s:.4g} s, expected at least {FEWEST_PERIODS - 1} after the first; "
            f"record more of them"
        )
    return found


def _harmonics(recording: Recording, window: NDArray[np.bool_], grid: Grid, count: int) -> Complex:
    """Complex amplitudes [deg] of harmonics 1 to ``count`` in one period, beside a mean."""
    phase = 2.0 * np.pi * (recording.time_s[window] - recording.command_time_s[0]) / grid.period_s
    turns = phase[:, None] * np.arange(1, count + 1)
    basis = np.hstack([np.ones((phase.size, 1)), np.cos(turns), np.sin(turns)])
    found = np.linalg.lstsq(basis, recording.angle_deg[window], rcond=None)[0]
    return np.asarray(found[1 : count + 1] - 1j * found[count + 1 :])


def _level(
    mean: Complex, spread: Array, lines: NDArray[np.int64], periods: int, unseen: float
) -> Level:
    """Power at some lines without noise, times ``unseen`` for lines that are not observed."""
    if lines.size == 0:
        return Level(0.0, 0.0, 0, 1.0)
    power = float(np.sum(np.abs(mean[lines - 1]) ** 2))
    noise = max(float(np.sum(spread[lines - 1])), 1e-300)
    freedom = 2.0 * lines.size
    return Level(
        float(np.sqrt(0.5 * unseen * max(power - noise, 0.0))),
        float(np.sqrt(0.5 * unseen * noise)),
        int(lines.size),
        float(fdtrc(freedom, freedom * (periods - 1), power / noise)),
    )


def _kind(line: int, grid: Grid) -> DistortionKind:
    if line in grid.excited:
        return "excited"
    return "odd" if line % 2 else "even"
