"""Errors of k, T and xi over a sweep's axes, with the Cramer-Rao limit beside them.

Over one axis a line, over two a map of fields; where an axis is drawn at random or has many values,
points.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from servosight.app.sweeps.axes import Joint, Rows

_SIGNS = {"xi": "ξ"}
_KINDS = {"error": "rms error of {}, %", "bound": "Cramér-Rao limit of {}, %"}
_MOST_FIELDS = 30
"""Values of an axis that a map has fields for."""
_WIDE = 10.0
"""Values over a wider range than this have a logarithmic scale."""


def draw_errors(row: Sequence[Axes], table: Rows, axes: Sequence[Joint], name: str) -> None:
    """The rms error of one parameter and the smallest that can be, in one scale.

    ``row`` has two panels for two axes, and one is enough for one axis.
    """
    sign = _SIGNS.get(name, name)
    if len(axes) == 1:
        _lines(row[0], table, axes[0], name)
        row[0].set_title(f"rms error of {sign}, %", fontsize=10)
        return
    columns = {f"{name}_{kind}": title.format(sign) for kind, title in _KINDS.items()}
    both = np.array([100.0 * one[c] for one in table for c in columns if one.get(c)])
    norm = LogNorm(both.min(), max(both.max(), 1.01 * both.min())) if both.size else LogNorm(1, 2)
    draw = _points if any(len(axis.values) > _MOST_FIELDS for axis in axes) else _fields
    for panel, (column, title) in zip(row, columns.items(), strict=True):
        panel.set_title(title, fontsize=10)
        panel.set_ylabel(axes[0].label)
        panel.set_xlabel(axes[1].label)
        draw(panel, table, axes, column, norm)


def _lines(panel: Axes, table: Rows, axis: Joint, name: str) -> None:
    """Error and limit over one axis."""
    places = axis.numbers(table)
    for kind, style in (("error", "o-"), ("bound", "--")):
        values = [one.get(f"{name}_{kind}") for one in table]
        known = sorted((x, 100.0 * y) for x, y in zip(places, values, strict=True) if y is not None)
        if known:
            label = "rms error" if kind == "error" else "Cramér-Rao limit"
            panel.plot(*zip(*known, strict=True), style, markersize=3.5, linewidth=1.2, label=label)
    panel.set_xscale("log" if _wide(places) else "linear")
    panel.set_yscale("log")
    panel.set_xlabel(axis.label)
    panel.legend(fontsize=7)
    if len(axis.values) <= _MOST_FIELDS:
        panel.set_xticks(sorted(set(places)), axis.texts())
        panel.minorticks_off()


def _fields(panel: Axes, table: Rows, axes: Sequence[Joint], column: str, norm: LogNorm) -> None:
    """One coloured field for each combination, with its value."""
    places = [{value: n for n, value in enumerate(axis.values)} for axis in axes]
    grid = np.full((len(places[0]), len(places[1])), np.nan)
    for row in table:
        if row.get(column) is not None:
            grid[places[0][axes[0].of(row)], places[1][axes[1].of(row)]] = 100.0 * row[column]
    panel.imshow(grid, norm=norm, cmap="viridis", aspect="auto")
    panel.set_yticks(range(len(places[0])), axes[0].texts())
    panel.set_xticks(range(len(places[1])), axes[1].texts())
    for (y, x), value in np.ndenumerate(grid):
        if np.isfinite(value):
            dark = value > 0.0 and float(norm(value)) < 0.6
            panel.text(
                x, y, f"{value:.2g}", ha="center", va="center", fontsize=8,
                color="white" if dark else "black",
            )  # fmt: skip


def _points(panel: Axes, table: Rows, axes: Sequence[Joint], column: str, norm: LogNorm) -> None:
    """One coloured point for each combination."""
    known = [row for row in table if row.get(column) is not None]
    y, x = (axis.numbers(known) for axis in axes)
    size = float(np.clip(4000.0 / max(len(known), 1), 0.5, 16.0))
    shade = [100.0 * row[column] for row in known]
    drawn = panel.scatter(x, y, c=shade, s=size, norm=norm, cmap="viridis", rasterized=True)
    for places, scale, axis in (
        (x, panel.set_xscale, panel.xaxis),
        (y, panel.set_yscale, panel.yaxis),
    ):
        if _wide(places):
            scale("log")
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_major_formatter(FuncFormatter(lambda value, place: f"{value:g}"))
            axis.set_minor_formatter(NullFormatter())
    figure = panel.get_figure(root=True)
    if figure is not None:
        figure.colorbar(drawn, ax=panel)


def _wide(values: Sequence[float]) -> bool:
    return bool(values) and min(values) > 0.0 and max(values) > _WIDE * min(values)
