"""Plots of angles over time: each takes an ``Axes``, or makes one, and returns it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from servosight.models.core._arrays import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MEASURED, MODEL, COMMAND, MARK = "#20242a", "#d55e00", "#8a939d", "#e6eff6"
HEIGHTS = (5, 2)
"""Of the angle's axes and of the residual's."""


class Recorded(Protocol):
    """What is drawn of a recording."""

    @property
    def name(self) -> str: ...
    @property
    def time_s(self) -> Array: ...
    @property
    def angle_deg(self) -> Array: ...
    @property
    def sigma_deg(self) -> Array | None: ...
    def command_at(self, time_s: Array) -> Array:
        """The command at these times [deg]."""
        ...


def plot_gain(
    frequency_hz: Array, response: NDArray[np.complex128], ax: Axes | None = None
) -> Axes:
    """Gain [dB] of a complex response over frequency."""
    axes = axes_of(ax)
    axes.semilogx(frequency_hz, 20.0 * np.log10(np.abs(response)), color=MODEL)
    axes.set(xlabel="frequency [Hz]", ylabel="gain [dB]")
    axes.grid(visible=True, which="both", lw=0.3)
    return axes


def axes_of(ax: Axes | None) -> Axes:
    """The axes to draw on: those given, or those of a new figure."""
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt  # heavy, and only needed to draw

    return plt.subplots(layout="constrained")[1]


def plot_recording(recording: Recorded, ax: Axes | None = None) -> Axes:
    """Measured angle and command over time, two sigma on either side of the angle."""
    axes = axes_of(ax)
    time_s, angle = recording.time_s, recording.angle_deg
    axes.plot(time_s, recording.command_at(time_s), color=COMMAND, linewidth=1.0, label="command")
    if recording.sigma_deg is not None:
        two = 2.0 * recording.sigma_deg
        axes.fill_between(time_s, angle - two, angle + two, color=MEASURED, alpha=0.25, linewidth=0)
    axes.plot(time_s, angle, color=MEASURED, linewidth=1.2, label="measured")
    axes.set_title(recording.name)
    axes.set_xlabel("time [s]")
    axes.set_ylabel("angle [deg]")
    axes.legend(loc="upper right")
    return axes


def plot_prediction(
    recording: Recorded,
    predicted_deg: Array,
    floor_deg: float,
    ax: Axes | None = None,
    marked_s: Sequence[tuple[float, float]] = (),
) -> Axes:
    """Measured angle and model above, measured minus model below; returns the upper axes.

    The lower axes take their place from ``ax``. The band about zero is the floor, ``marked_s`` are
    stretches of time to mark.
    """
    axes = axes_of(ax)
    below = _axes_below(axes)
    time_s, residual = recording.time_s, recording.angle_deg - predicted_deg
    axes.plot(time_s, recording.angle_deg, color=MEASURED, linewidth=1.2, label="measured")
    axes.plot(time_s, predicted_deg, color=MODEL, linewidth=1.0, linestyle="--", label="model")
    below.axhspan(-floor_deg, floor_deg, color=COMMAND, alpha=0.3, linewidth=0)
    below.plot(time_s, residual, color=MODEL, linewidth=0.8)
    for start, end in marked_s:
        for one in (axes, below):
            one.axvspan(start, end, color=MARK, linewidth=0, zorder=0)
    rms = float(np.sqrt(np.mean(residual**2)))
    axes.set_title(f"{recording.name}: error {rms:.3g} deg rms, floor {floor_deg:.3g} deg")
    axes.set_ylabel("angle [deg]")
    axes.tick_params(labelbottom=False)
    axes.legend(loc="upper right")
    below.set_ylabel("residual\n[deg]")
    below.set_xlabel("time [s]")
    return axes


def _axes_below(axes: Axes) -> Axes:
    """New axes in the lower part of the place that ``axes`` had; these keep the upper part."""
    place = axes.get_subplotspec()
    if place is not None:
        halves = place.subgridspec(2, 1, height_ratios=HEIGHTS, hspace=0.08)
        axes.set_subplotspec(halves[0])
        return axes.figure.add_subplot(halves[1], sharex=axes)
    left, bottom, width, height = axes.get_position().bounds
    share = HEIGHTS[1] / sum(HEIGHTS)
    axes.set_position((left, bottom + height * share, width, height * (1.0 - share)))
    lower_part = (left, bottom, width, 0.85 * height * share)
    return axes.figure.add_axes(lower_part, sharex=axes)
