"""Gain, phase and coherence: the servo's against the model's, both from the same windows of data.

Welch's method with the command as input (Bendat and Piersol, Random Data, 4th ed., 2010, chapter 6
and table 9.6), at the excited lines where the command is an odd multisine (Pintelon and Schoukens,
System Identification, 2nd ed., 2012, section 2.4). What windows do to the measured response they do
to the model's as well, so the two compare even where both are biased.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from servosight.diagnose.residuals._judged import Judged
from servosight.models.core import Array, Complex, Recording
from servosight.models.excitation import Grid, grid_of

FEWEST_SEGMENTS = 4
EXCITED = 0.003
"""Frequencies count where the command has this share of its strongest line's amplitude."""
HIGHEST = 0.4
"""Of the sample rate; the angle's faster motion folds down onto the lines above."""
MOST_MISSING = 0.1
"""Segments with a larger share of missing samples are left out."""
_DENSE = 8
"""Points to a row of the command, and to a step of its windows."""
_OVERLAP_WORTH = 0.95
"""Hann segments that overlap by half are worth so many independent ones each."""


@dataclass(frozen=True)
class Response:
    """Responses to the command over ``frequency_hz``, (lines,) each, of one recording.

    ``measured`` and ``model`` are complex gains, ``sigma`` the standard deviation of ``measured``
    (complex: of real and imaginary part together). ``coherence`` is the share of the measured power
    that follows the command linearly, ``model_coherence`` the same for the simulated angle: less
    than 1 by leakage, and by what is not linear in the model. ``power_deg2`` is the mean square of
    the command at each line. ``averages`` is the number of independent spectra. ``periodic``: at
    the lines of a periodic command, where the coherence is that from period to period.
    """

    recording: Recording
    frequency_hz: Array
    measured: Complex
    model: Complex
    sigma: Array
    coherence: Array
    model_coherence: Array
    power_deg2: Array
    averages: float
    periodic: bool

    @property
    def misfit_deg2(self) -> Array:
        """Mean square of the error that another linear model would take at each line, (lines,)."""
        return np.asarray(np.abs(self.measured - self.model) ** 2 * self.power_deg2)

    @property
    def p(self) -> Array:
        """How often chance makes measured and model differ as much at a line, (lines,)."""
        ratio = np.abs(self.measured - self.model) ** 2 / np.maximum(self.sigma**2, 1e-300)
        # Sigma itself is known from so many spectra: an F distribution with 2 degrees on top.
        freedom = max(self.averages - 1.0, 1.0)
        return np.asarray((1.0 + ratio / freedom) ** -freedom)


def response(judged: Sequence[Judged]) -> Response | None:
    """The response of the longest recording; None where that is too short to separate noise."""
    one = max(judged, key=lambda item: item.recording.time_s.size)
    recording = one.recording
    grid = grid_of(recording.command_time_s, recording.command_deg)
    at_lines = None if grid is None else _at_lines(one, grid)
    return at_lines or _welch(one)


def _welch(one: Judged) -> Response | None:
    recording = one.recording
    step = float(np.median(np.diff(recording.time_s)))
    slots = int(recording.duration_s / step)
    length = int(2 ** np.floor(np.log2(max(slots / 4, 1))))
    # A gap of hours is no place to look at: segments start where there are samples.
    if length < 16 or slots > 50 * recording.time_s.size:
        return None
    window = np.hanning(length + 1)[:-1]
    spectra = []
    for start in range(0, slots - length + 1, length // 2):
        grid = recording.time_s[0] + step * (start + np.arange(length))
        inside = np.searchsorted(recording.time_s, [grid[0] - 0.5 * step, grid[-1] + 0.5 * step])
        if np.diff(inside)[0] < (1.0 - MOST_MISSING) * length:
            continue
        angles = (
            np.interp(grid, recording.time_s, recording.angle_deg),
            np.interp(grid, recording.time_s, one.predicted_deg),
        )
        spectra.append(
            [
                _command_spectrum(recording, grid[0], step, length),
                *(np.fft.rfft(window * (angle - angle.mean())) for angle in angles),
            ]
        )
    if len(spectra) < FEWEST_SEGMENTS:
        return None
    # Lines 0 and 1 hold the window's own width about the mean.
    lines = np.arange(2, int(HIGHEST * length))
    command, angle, model = np.array(spectra).transpose(1, 0, 2)[:, :, lines]
    scale = 2.0 / (length * float(np.sum(window**2)))
    frequency = lines / (length * step)
    averages = _OVERLAP_WORTH * len(spectra)
    return _of(recording, frequency, (command, angle, model), scale, averages, False)


def _command_spectrum(recording: Recording, start_s: float, step_s: float, length: int) -> Complex:
    """Of ``length`` steps of the command from ``start_s``, (length // 2 + 1,), by a Hann window.

    Of the command itself, not of its samples: a held step between two of them would seem to come
    at the second, late by half of ``step_s`` on average, and its higher harmonics fold down.
    """
    count = _DENSE * length
    place = (np.arange(count) + 0.5) / _DENSE  # in steps: the middles of their parts
    command = recording.command_at(start_s + step_s * place)
    window = 0.5 - 0.5 * np.cos(2.0 * np.pi * place / length)
    spectrum = np.fft.rfft(window * (command - command.mean()))[: length // 2 + 1] / _DENSE
    turns = np.arange(length // 2 + 1) * place[0] / length
    return np.asarray(spectrum * np.exp(-2j * np.pi * turns))


def _of(
    recording: Recording,
    frequency_hz: Array,
    spectra: tuple[Complex, Complex, Complex],
    scale: float,
    averages: float,
    periodic: bool,
) -> Response | None:
    """From spectra of command, angle and model (segments, lines) to responses at excited lines.

    None where the command rests throughout the segments.
    """
    command, angle, model = spectra
    power = np.mean(np.abs(command) ** 2, axis=0)
    kept = power > EXCITED**2 * power.max()
    if not kept.any():
        return None
    command, angle, model = command[:, kept], angle[:, kept], model[:, kept]
    power = power[kept]
    measured, coherence = _gain(command, angle, power)
    simulated, model_coherence = _gain(command, model, power)
    left = (1.0 - coherence) * np.mean(np.abs(angle) ** 2, axis=0)
    sigma = np.sqrt(left / (power * max(averages - 1.0, 1.0)))
    return Response(
        recording,
        frequency_hz[kept],
        measured,
        simulated,
        sigma,
        coherence,
        model_coherence,
        scale * power,
        averages,
        periodic,
    )


def _gain(command: Complex, answer: Complex, power: Array) -> tuple[Complex, Array]:
    """Response, and coherence in 0 to 1."""
    cross = np.mean(command.conj() * answer, axis=0)
    own = np.maximum(np.mean(np.abs(answer) ** 2, axis=0), 1e-300)
    return cross / power, np.clip(np.abs(cross) ** 2 / (power * own), 0.0, 1.0)


def _command_lines(recording: Recording, grid: Grid, period: int) -> Complex:
    """Complex amplitudes of the command itself, not of its samples: held steps have images."""
    end = recording.command_time_s[0] + grid.period_s
    count = _DENSE * int(np.searchsorted(recording.command_time_s, end))
    share = (np.arange(count) + 0.5) / count
    start = recording.command_time_s[0] + period * grid.period_s
    command = recording.command_at(start + share * grid.period_s)
    turns = np.exp(-2j * np.pi * grid.excited[:, None] * share)
    return np.asarray(2.0 / count * (turns @ command))


def _at_lines(one: Judged, grid: Grid) -> Response | None:
    """Settled whole periods as segments, by least squares at the excited lines.

    Distortion that repeats with the period does not lower the coherence: it is no noise.
    """
    recording = one.recording
    time_s = recording.time_s - recording.command_time_s[0]
    lines = grid.excited
    whole = 0.9 * grid.period_s / float(np.median(np.diff(time_s)))
    spectra = []
    for period in range(1, grid.periods):
        inside = np.floor(time_s / grid.period_s + 1e-9) == period
        if inside.sum() < max(whole, 2.5 * lines[-1]):
            continue
        turns = 2.0 * np.pi * time_s[inside, None] / grid.period_s * lines
        basis = np.hstack([np.ones((turns.shape[0], 1)), np.cos(turns), np.sin(turns)])
        signals = np.stack(
            [
                recording.angle_deg[inside],
                one.predicted_deg[inside],
            ],
            axis=1,
        )
        found = np.linalg.lstsq(basis, signals, rcond=None)[0]
        answers = (found[1 : lines.size + 1] - 1j * found[lines.size + 1 :]).T
        spectra.append([_command_lines(recording, grid, period), *answers])
    if len(spectra) < 2:
        return None
    command, angle, model = np.array(spectra).transpose(1, 0, 2)
    frequency = lines / grid.period_s
    return _of(recording, frequency, (command, angle, model), 0.5, float(len(spectra)), True)
