"""Tables of a scenario: the true linear servo, its command, and a known disturbance."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from servosight.models import excitation as shapes
from servosight.models.core import DISTURBANCE, Array, Signals, within
from servosight.models.excitation import Excitation
from servosight.sim.bench import SHORTEST_T_S, BenchParameters

LARGEST_DEG = 180.0


@dataclass(frozen=True)
class LinearServo:
    """The true linear servo: gain k [-], T [s], xi [-], and the angle at zero command [deg]."""

    k: Annotated[float, within(-100.0, 100.0, "and not 0")] = 1.0
    T: Annotated[float, within(SHORTEST_T_S, 2.0, "seconds")] = 0.02
    xi: Annotated[float, within(0.02, 20.0, "as a ratio")] = 0.6
    bias: Annotated[float, within(-LARGEST_DEG, LARGEST_DEG, "degrees")] = 0.0

    def bench(self) -> BenchParameters:
        """A test bench with this transfer function."""
        return BenchParameters.with_response(self.k, self.T, self.xi, self.bias)


@dataclass(frozen=True)
class CommandSettings:
    """The command: a ``kind`` of ``KINDS``, in rows at ``rate_hz``.

    ``dwell_s`` is for steps, ``frequency_hz`` for sine and triangle, ``low_hz`` and ``high_hz``
    for chirp and multisine.
    """

    kind: str = "standard"
    amplitude_deg: Annotated[float, within(-LARGEST_DEG, LARGEST_DEG, "degrees")] = 20.0
    rate_hz: Annotated[float, within(1.0, 1e4, "Hz")] = 250.0
    dwell_s: Annotated[float, within(1e-3, 600.0, "seconds")] = 0.8
    frequency_hz: Annotated[float, within(1e-3, 5e3, "Hz")] = 1.0
    low_hz: Annotated[float, within(1e-3, 5e3, "Hz and less than high_hz")] = 0.5
    high_hz: Annotated[float, within(1e-3, 5e3, "Hz and more than low_hz")] = 9.0

    def rows(self, duration_s: float, seed: int) -> Excitation:
        """The command's rows; ``seed`` is for kinds that are drawn."""
        if self.kind == "standard":
            return shapes.standard(duration_s, self.amplitude_deg, seed, self.rate_hz)
        time_s = np.arange(round(duration_s * self.rate_hz) + 1) / self.rate_hz
        return Excitation(time_s, _SHAPES[self.kind](time_s, self, seed))


@dataclass(frozen=True)
class DisturbanceSettings:
    """Pulses of a known disturbance for effects that need one, up and down in turn."""

    amplitude: Annotated[float, within(-1e6, 1e6, "in its unit")] = 20.0
    period_s: Annotated[float, within(1e-2, 600.0, "seconds")] = 1.7
    width_s: Annotated[float, within(1e-3, 600.0, "seconds and less than period_s")] = 0.4
    unit: str = "N"

    def signals(self, duration_s: float) -> Signals:
        """The rows at which it changes."""
        starts = np.arange(0.5 * self.period_s, duration_s, self.period_s)
        sizes = np.where(np.arange(starts.size) % 2 == 0, self.amplitude, -self.amplitude)
        width = min(self.width_s, 0.999 * self.period_s)
        time_s = np.concatenate([[0.0], np.stack([starts, starts + width], axis=1).ravel()])
        values = np.concatenate([[0.0], np.stack([sizes, 0.0 * sizes], axis=1).ravel()])
        return Signals(time_s, {f"{DISTURBANCE}{self.unit}": values})


CommandFunction = Callable[[Array, CommandSettings, int], Array]

_SHAPES: Mapping[str, CommandFunction] = {
    "steps": lambda t, m, seed: shapes.steps(t, m.amplitude_deg, m.dwell_s, seed),
    "chirp": lambda t, m, seed: shapes.chirp(t, m.amplitude_deg, m.low_hz, m.high_hz),
    "triangle": lambda t, m, seed: shapes.triangle(t, m.amplitude_deg, m.frequency_hz),
    "sine": lambda t, m, seed: shapes.sine(t, m.amplitude_deg, m.frequency_hz),
    "multisine": lambda t, m, seed: shapes.multisine(t, m.amplitude_deg, m.low_hz, m.high_hz, seed),
}

KINDS = ("standard", *_SHAPES)
"""Commands that ``[motion]`` knows."""
