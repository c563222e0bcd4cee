"""Plots of results for a notebook: each takes an ``Axes``, or makes one, and returns it."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING

from servosight.models.core import axes_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

BEFORE, AFTER, FLOOR = "#d55e00", "#0072b2", "#8f9aa5"
LEAST_DEG = 1e-9
_LETTERS = 60
"""Number of names side by side below a figure of usual width; longer names take more lines."""


def plot_ladder(steps: Mapping[str, float], floor_deg: float, ax: Axes | None = None) -> Axes:
    """Error [deg] of each step by its name on a logarithmic scale, and the floor below it."""
    axes = axes_of(ax)
    errors = [max(error, LEAST_DEG) for error in steps.values()]
    colours = [BEFORE, *[AFTER] * (len(errors) - 1)]
    bars = axes.bar(range(len(errors)), errors, color=colours, width=0.6)
    axes.bar_label(bars, [f"{error:.3g} deg" for error in errors], padding=2)
    floor = max(floor_deg, LEAST_DEG)
    axes.axhline(floor, color=FLOOR)
    axes.annotate(
        f"floor {floor:.3g} deg",
        (0.99, floor),
        (0, 3),
        xycoords=("axes fraction", "data"),
        textcoords="offset points",
        ha="right",
    )
    axes.set_yscale("log")
    axes.set_ylim(0.5 * min(*errors, floor), 3.0 * max(*errors, floor))
    width = max(_LETTERS // len(errors), 1)
    names = [textwrap.fill(name, width, break_long_words=False) for name in steps]
    axes.set_xticks(range(len(errors)), names)
    axes.set_ylabel("error on test data, rms [deg]")
    return axes
