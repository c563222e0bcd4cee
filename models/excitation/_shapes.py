"""Command signals: shapes that excite a servo, sampled as a sender would send them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from servosight.models import io as series
from servosight.models.core import Array, InputError, Signals, command_at, write_text
from servosight.models.io import read_sheet, table_text


@dataclass(frozen=True)
class Excitation:
    """Rows of a command: ``time_s`` rising, ``command_deg`` held from each row to the next.

    ``disturbance`` is the known one that acts meanwhile, where there is one.
    """

    time_s: Array
    command_deg: Array
    disturbance: Signals | None = None

    @property
    def duration_s(self) -> float:
        """Time from the first row to the last [s]."""
        return float(self.time_s[-1] - self.time_s[0])

    def at(self, time_s: Array) -> Array:
        """The command at ``time_s`` [deg], held between rows."""
        return command_at(self.time_s, self.command_deg, time_s)

    def save(self, path: Path) -> None:
        """Write ``time_s,command_deg`` to a microsecond and microdegree; all of it or nothing."""
        columns = (np.round(self.time_s, 6), np.round(self.command_deg, 6))
        write_text(path, table_text(("time_s", "command_deg"), columns))

    @classmethod
    def load(cls, path: Path) -> Excitation:
        """Read what :meth:`save` writes; InputError names the row that is no number."""
        sheet = read_sheet(path)
        for name in ("time_s", "command_deg"):
            if name not in sheet.header:
                raise InputError(
                    f"{path}, row 1: no column {name} among {', '.join(sheet.header)[:200]}, "
                    f"expected time_s,command_deg; rename the columns"
                )
        rows = sheet.columns(["time_s", "command_deg"])
        time, command = (
            series.Series(path, name, column, column, sheet.numbers)
            for name, column in zip(("time_s", "command_deg"), rows.T, strict=True)
        )
        for column in (time, command):
            series.check_finite(column)
        series.check_time(time)
        series.check_angle(command)
        if len(rows) < 2 or np.ptp(rows[:, 1]) == 0.0:
            raise InputError(
                f"{path}: column command_deg never moves, expected a changing command; write one "
                f"with `servosight excite`"
            )
        return cls(rows[:, 0], rows[:, 1])


def steps(time_s: Array, amplitude_deg: float, dwell_s: float, seed: int) -> Array:
    """Random levels within +-``amplitude_deg``, each held for ``dwell_s``; starts at zero."""
    rng = np.random.default_rng(seed)
    index = np.floor((time_s - time_s[0]) / dwell_s + 1e-9).astype(int)
    levels = rng.uniform(-1.0, 1.0, index[-1] + 1)
    levels += np.sign(levels) * 0.2
    levels[0] = 0.0
    return np.asarray(amplitude_deg * np.clip(levels, -1.0, 1.0)[index])


def chirp(time_s: Array, amplitude_deg: float, low_hz: float, high_hz: float) -> Array:
    """Logarithmic sweep from ``low_hz`` to ``high_hz`` over the whole of ``time_s``."""
    t = time_s - time_s[0]
    rate = np.log(high_hz / low_hz) / t[-1]
    return np.asarray(amplitude_deg * np.sin(2 * np.pi * low_hz * np.expm1(rate * t) / rate))


def triangle(time_s: Array, amplitude_deg: float, frequency_hz: float) -> Array:
    """Triangle wave that starts at zero and rises."""
    phase = (time_s - time_s[0]) * frequency_hz
    return np.asarray(amplitude_deg * (2 / np.pi) * np.arcsin(np.sin(2 * np.pi * phase)))


def sine(time_s: Array, amplitude_deg: float, frequency_hz: float) -> Array:
    """Sine wave; the paper's own excitation is 20 deg at 1 Hz."""
    return np.asarray(amplitude_deg * np.sin(2 * np.pi * frequency_hz * (time_s - time_s[0])))


def multisine(
    time_s: Array, amplitude_deg: float, low_hz: float, high_hz: float, seed: int
) -> Array:
    """Random-phase odd multisine with peak ``amplitude_deg`` (Pintelon and Schoukens 2012)."""
    t = time_s - time_s[0]
    rng = np.random.default_rng(seed)
    base = low_hz
    harmonics = np.arange(1, max(int(high_hz / base), 1) + 1, 2)
    phases = rng.uniform(0, 2 * np.pi, harmonics.size)
    wave = np.sin(2 * np.pi * base * t[:, None] * harmonics + phases).sum(axis=1)
    wave -= wave[0]
    return np.asarray(amplitude_deg * wave / np.max(np.abs(wave)))


_TAPS = {4: 3, 5: 3, 6: 5, 7: 6, 9: 5, 10: 7, 11: 9, 15: 14, 17: 14, 20: 17}
"""Second tap of a maximum-length register of each length; the first is the length itself."""


def prbs(time_s: Array, amplitude_deg: float, clock_s: float, seed: int) -> Array:
    """Pseudo-random binary sequence +-``amplitude_deg``, one bit each ``clock_s``; zero at first.

    The shortest maximum-length shift register that does not repeat within ``time_s`` (Soderstrom
    and Stoica, System Identification, 1989, section 5.3); ``seed`` sets where it begins.
    """
    index = np.floor((time_s - time_s[0]) / clock_s + 1e-9).astype(int)
    length = next((n for n in _TAPS if 2**n - 1 >= index[-1]), max(_TAPS))
    bits = list(np.random.default_rng(seed).integers(0, 2, length))
    bits[0] = 1  # all zeros would stay zeros
    while len(bits) < index[-1]:
        bits.append(bits[-length] ^ bits[-_TAPS[length]])
    levels = np.concatenate([[0.0], 2.0 * np.array(bits) - 1.0])
    return np.asarray(amplitude_deg * levels[index])


def standard(
    duration_s: float = 20.0, amplitude_deg: float = 20.0, seed: int = 0, rate_hz: float = 250.0
) -> Excitation:
    """Rest, steps, chirp, triangles at two amplitudes and multisine, one after the other.

    Two amplitudes and slow reversals separate play, dead zone and dry friction; steps show
    limits; the chirp shows dynamics. Rows at ``rate_hz``, as a sender's loop would write them.
    """
    time_s = np.arange(int(round(duration_s * rate_hz)) + 1) / rate_hz
    rest = max(0.3, 0.02 * duration_s)
    parts: list[tuple[float, Callable[[Array], Array]]] = [
        (0.30, lambda t: steps(t, amplitude_deg, 0.04 * duration_s, seed)),
        (0.25, lambda t: chirp(t, 0.6 * amplitude_deg, 0.3, 12.0)),
        (0.15, lambda t: triangle(t, 0.75 * amplitude_deg, 0.5)),
        (0.10, lambda t: triangle(t, 0.15 * amplitude_deg, 1.0)),
        (0.20, lambda t: multisine(t, 0.8 * amplitude_deg, 0.5, 9.0, seed + 1)),
    ]
    command = np.zeros_like(time_s)
    edge = rest
    for share, shape in parts:
        inside = (time_s >= edge) & (time_s < edge + share * (duration_s - rest))
        command[inside] = shape(time_s[inside])
        edge += share * (duration_s - rest)
    return Excitation(time_s, command)
