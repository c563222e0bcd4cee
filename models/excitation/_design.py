"""Commands designed within limits: each shape as large and fast as angle, rate and time allow."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from servosight.models.core import Array, InputError, check_seed, did_you_mean, either
from servosight.models.excitation import _shapes as waves
from servosight.models.excitation._limits import CommandLimits
from servosight.models.excitation._multisine import multisine_period, random_grid
from servosight.models.excitation._shapes import Excitation

PERIOD_S = 5.0
FEWEST_PERIODS = 3
"""Of a multisine: one to settle, two to separate noise from the periodic response."""
FEWEST_LINES = 4
SMALL = 0.25
"""The smaller of two triangles, as a share of the larger."""


@dataclass(frozen=True)
class Form:
    """What is left to choose in a shape. None: what the shape has by default.

    ``frequency_hz`` for sine and triangle, ``low_hz`` and ``high_hz`` for chirp and multisine,
    ``dwell_s`` for steps and prbs.
    """

    frequency_hz: float | None = None
    low_hz: float | None = None
    high_hz: float | None = None
    dwell_s: float | None = None


FORMED: Mapping[str, tuple[str, ...]] = {
    "frequency_hz": ("sine", "triangle"),
    "low_hz": ("chirp", "multisine"),
    "high_hz": ("chirp", "multisine"),
    "dwell_s": ("steps", "prbs"),
}
"""Which shapes each number of a :class:`Form` applies to."""


@dataclass(frozen=True)
class Design:
    """A command, what it is in words, and where the limits were in its way."""

    excitation: Excitation
    words: str
    notes: tuple[str, ...] = ()


def design(shape: str, limits: CommandLimits, form: Form | None = None, seed: int = 0) -> Design:
    """The ``shape`` (a key of :data:`SHAPES`) within ``limits``.

    Raises InputError where the shape is unknown, does not have a number of ``form`` or cannot be
    had within the limits, and for a seed that is none.
    """
    if shape not in SHAPES:
        raise InputError(
            f"shape {shape!r}{did_you_mean(shape, [*SHAPES, 'optimal'])}: expected one of "
            f"{', '.join(SHAPES)} or optimal; choose one of these"
        )
    check_seed(seed)
    wanted = form or Form()
    for name, shapes in FORMED.items():
        value = getattr(wanted, name)
        given = either(name, f"--{name.rpartition('_')[0]}")
        if value is not None and not 0.0 < value < np.inf:
            raise InputError(f"{given} is {value:g}, expected more than 0; give a larger one")
        if value is not None and shape not in shapes:
            raise InputError(
                f"{given} is {value:g}, expected none for the shape {shape}, only for "
                f"{' and '.join(shapes)}; leave it out"
            )
    made = SHAPES[shape](replace(limits, centre_deg=0.0), wanted, seed)
    rows = made.excitation
    return replace(made, excitation=Excitation(rows.time_s, limits.centre_deg + rows.command_deg))


def slewed(command_deg: Array, limits: CommandLimits) -> Array:
    """The command, starting at zero and following at no more than the rate; (rows,)."""
    if limits.rate_deg_s is None:
        return command_deg
    most = limits.rate_deg_s / limits.rows_hz
    out = np.empty_like(command_deg)
    now = 0.0
    for n, wanted in enumerate(command_deg.tolist()):
        now += min(max(wanted - now, -most), most)
        out[n] = now
    return out


def _scaled(unit: Array, limits: CommandLimits, words: Callable[[float], str]) -> Design:
    """A smooth wave of peak 1, as large as angle and rate allow."""
    steepest = float(np.max(np.abs(np.diff(unit)))) * limits.rows_hz
    amplitude = limits.angle_deg
    notes: tuple[str, ...] = ()
    if limits.rate_deg_s is not None and amplitude * steepest > limits.rate_deg_s:
        amplitude = limits.rate_deg_s / steepest * (1.0 - 1e-9)
        notes = (
            f"kept to {amplitude:.3g} of {limits.angle_deg:.4g} deg: more would exceed "
            f"{limits.rate_deg_s:.4g} deg/s",
        )
    return Design(Excitation(limits.time_s[: unit.size], amplitude * unit), words(amplitude), notes)


def _levels(limits: CommandLimits, dwell_s: float) -> tuple[float, tuple[str, ...]]:
    """The amplitude at which the longest change takes at most half of the time for it."""
    if limits.rate_deg_s is None or limits.rate_deg_s * dwell_s >= 4.0 * limits.angle_deg:
        return limits.angle_deg, ()
    amplitude = limits.rate_deg_s * dwell_s / 4.0
    return amplitude, (
        f"kept to {amplitude:.3g} of {limits.angle_deg:.4g} deg: at {limits.rate_deg_s:.4g} deg/s "
        f"a larger change would take more than half of {dwell_s:.3g} s",
    )


def _needs(limits: CommandLimits, shape: str, seconds: float, why: str) -> None:
    if limits.duration_s < seconds * (1.0 - 1e-9):
        raise InputError(
            f"the {shape} has {limits.duration_s:g} s, expected at least {seconds:.3g} s for "
            f"{why}; give a longer duration or a higher frequency"
        )


def _steps(limits: CommandLimits, form: Form, seed: int) -> Design:
    reach = 0.0 if limits.rate_deg_s is None else 4.0 * limits.angle_deg / limits.rate_deg_s
    dwell = form.dwell_s or max(0.04 * limits.duration_s, 0.1, min(reach, limits.duration_s / 8.0))
    _needs(limits, "steps", 3.0 * dwell, "a rest and two levels")
    amplitude, notes = _levels(limits, dwell)
    wave = slewed(waves.steps(limits.time_s, amplitude, dwell, seed), limits)
    words = f"steps up to {amplitude:.3g} deg, held for {dwell:.3g} s"
    return Design(Excitation(limits.time_s, wave), words, notes)


def _prbs(limits: CommandLimits, form: Form, seed: int) -> Design:
    clock = form.dwell_s or 0.15
    _needs(limits, "prbs", 8.0 * clock, "eight bits")
    amplitude, notes = _levels(limits, clock)
    wave = slewed(waves.prbs(limits.time_s, amplitude, clock, seed), limits)
    words = f"pseudo-random binary sequence of {amplitude:.3g} deg, one bit each {clock:.3g} s"
    return Design(Excitation(limits.time_s, wave), words, notes)


def _chirp(limits: CommandLimits, form: Form, seed: int) -> Design:
    """A logarithmic sweep; where the rate is in the way, the amplitude falls as 1 / frequency."""
    low, high = _band(limits, form, 0.3, 12.0)
    _needs(limits, "chirp", 1.0 / low, f"one period at {low:.3g} Hz")
    wave = waves.chirp(limits.time_s, 1.0, low, high)
    amplitude = np.full(wave.size, limits.angle_deg)
    if limits.rate_deg_s is not None:
        frequency = low * (high / low) ** (limits.time_s / limits.time_s[-1])
        amplitude = np.minimum(amplitude, limits.rate_deg_s / (2.0 * np.pi * frequency))
    notes: tuple[str, ...] = ()
    if amplitude[-1] < limits.angle_deg:
        notes = (
            f"falls to {amplitude[-1]:.3g} of {limits.angle_deg:.4g} deg at {high:.3g} Hz: more "
            f"would exceed {limits.rate_deg_s:.4g} deg/s",
        )
    wave = slewed(amplitude * wave, limits)
    words = f"chirp of {amplitude[0]:.3g} deg from {low:.3g} to {high:.3g} Hz"
    return Design(Excitation(limits.time_s, wave), words, notes)


def _multisine(limits: CommandLimits, form: Form, seed: int) -> Design:
    """Whole periods, so that the periodic part can be separated from noise."""
    low, high = _band(limits, form, 0.2, 9.0)
    periods = max(FEWEST_PERIODS, round(limits.duration_s / PERIOD_S))
    rows = 2 * int(limits.duration_s * limits.rows_hz / periods / 2.0 + 1e-9)
    base_hz = limits.rows_hz / rows
    first, last = max(int(np.ceil(low / base_hz - 1e-6)), 1), int(high / base_hz + 1e-6)
    if (last - first) // 2 + 1 < FEWEST_LINES:
        raise InputError(
            f"the multisine has {limits.duration_s:g} s for {FEWEST_PERIODS} periods with "
            f"{FEWEST_LINES} odd lines from {low:.3g} to {high:.3g} Hz, expected a longer "
            f"duration or a wider band; give one of them"
        )
    harmonics = random_grid(first, last, seed)
    unit = np.tile(multisine_period(rows, harmonics, seed), periods + 1)[: periods * rows + 1]
    return _scaled(
        unit,
        limits,
        lambda amplitude: (
            f"odd multisine of {amplitude:.3g} deg, {harmonics.size} lines from "
            f"{harmonics[0] * base_hz:.3g} to {harmonics[-1] * base_hz:.3g} Hz, {periods} periods"
        ),
    )


def _sine(limits: CommandLimits, form: Form, seed: int) -> Design:
    frequency = _below_rows(limits, form.frequency_hz or 1.0)
    _needs(limits, "sine", 1.0 / frequency, "one period")
    unit = waves.sine(limits.time_s, 1.0, frequency)
    return _scaled(unit, limits, lambda a: f"sine of {a:.3g} deg at {frequency:.3g} Hz")


def _triangle(limits: CommandLimits, form: Form, seed: int) -> Design:
    """Whole turns at the full amplitude for the first half, then at a quarter of it."""
    frequency = _below_rows(limits, form.frequency_hz or 0.5)
    _needs(limits, "triangle", 2.0 / frequency, "one turn at each of two amplitudes")
    half = np.floor(0.5 * limits.duration_s * frequency) / frequency
    inside = limits.time_s < half - 0.5 / limits.rows_hz
    rest = limits.time_s[~inside]
    unit = np.concatenate(
        [
            waves.triangle(limits.time_s[inside], 1.0, frequency),
            waves.triangle(rest, SMALL, frequency),
        ]
    )
    return _scaled(
        unit,
        limits,
        lambda a: f"triangles of {a:.3g} and {SMALL * a:.3g} deg at {frequency:.3g} Hz",
    )


def _standard(limits: CommandLimits, form: Form, seed: int) -> Design:
    _needs(limits, "standard mix", 5.0, "its parts")
    made = waves.standard(limits.duration_s, limits.angle_deg, seed, limits.rows_hz)
    wave = slewed(made.command_deg, limits)
    notes: tuple[str, ...] = ()
    if not np.array_equal(wave, made.command_deg):
        notes = (f"jumps and fast parts follow at {limits.rate_deg_s:.4g} deg/s",)
    words = f"standard mix of {limits.angle_deg:.3g} deg"
    return Design(Excitation(made.time_s, wave), words, notes)


def _band(limits: CommandLimits, form: Form, low: float, high: float) -> tuple[float, float]:
    low, high = form.low_hz or low, _below_rows(limits, form.high_hz or high)
    if low >= high:
        raise InputError(
            f"the band runs from {low:g} to {high:g} Hz, expected a low frequency below the high "
            f"one; change one of them"
        )
    return low, high


def _below_rows(limits: CommandLimits, frequency_hz: float) -> float:
    if frequency_hz > 0.2 * limits.rows_hz:
        raise InputError(
            f"a frequency of {frequency_hz:g} Hz needs more rows, expected at most a fifth of "
            f"{limits.rows_hz:g} rows a second; lower it or send more rows"
        )
    return frequency_hz


SHAPES: Mapping[str, Callable[[CommandLimits, Form, int], Design]] = {
    "steps": _steps,
    "chirp": _chirp,
    "multisine": _multisine,
    "prbs": _prbs,
    "triangle": _triangle,
    "sine": _sine,
    "standard": _standard,
}
"""Builders by name; they know no centre."""
