"""One picture of a sweep: maps of the errors with their limit beside them, detection by size."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from servosight.models.core import InputError, marked_png, write_bytes
from servosight.scenarios.sweeps import Found, Summary, value_text

CORE = ("k", "T", "xi")
_SIGNS = {"xi": "ξ"}
_CURVES = 8
"""Detection curves in one panel; with more, the picture would not be read."""
_DPI = 130

Rows = Sequence[Mapping[str, Any]]


def write_picture(found: Summary, path: Path) -> None:
    """Draw a sweep; InputError where it has nothing to draw."""
    maps = map_axes(found)
    errors = [name for name in CORE if f"{name}_error" in found.table[0]] if maps else []
    panels = list(_panels(found))
    if not errors and not panels:
        raise InputError(
            f"{path}: this sweep has no errors over two axes and no sizes of effects, expected one "
            f"of them to draw; print it without --plot"
        )
    columns = 1 if len(panels) == 1 and not errors else 2
    rows = max(len(errors), -(-len(panels) // columns))
    figure = Figure(figsize=(4.8 * max(columns, 1.5), 3.3 * rows + 0.4), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(rows, columns, squeeze=False)
    if errors and maps:
        for row, name in zip(grid, errors, strict=False):
            _map_pair(row, found.table, maps, name)
    else:
        for axes, (title, answers) in zip(grid.flat, panels, strict=False):
            _curves(axes, title, answers)
        for axes in grid.flat[len(panels) :]:
            axes.set_visible(False)
    figure.suptitle(found.about or found.name, fontsize=11)
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=_DPI)
    write_bytes(path, marked_png(data.getvalue()))


def map_axes(found: Summary) -> tuple[str, str] | None:
    """The two axes of a map: the first ones, where the sweep has just two."""
    if len(found.axes) != 2 or not found.table:
        return None
    return found.axes[0], found.axes[1]


def _map_pair(row: Sequence[Axes], table: Rows, axes: tuple[str, str], name: str) -> None:
    """The rms error of one parameter, and beside it the smallest that can be, in one scale."""
    error, bound = (_grid(table, axes, f"{name}_{kind}") for kind in ("error", "bound"))
    both = np.concatenate([error.ravel(), bound.ravel()])
    both = 100.0 * both[np.isfinite(both) & (both > 0.0)]
    norm = LogNorm(both.min(), max(both.max(), 1.01 * both.min())) if both.size else LogNorm(1, 2)
    sign = _SIGNS.get(name, name)
    for panel, values, title in (
        (row[0], error, f"rms error of {sign}, %"),
        (row[1], bound, f"Cramér-Rao limit of {sign}, %"),
    ):
        panel.imshow(100.0 * values, norm=norm, cmap="viridis", aspect="auto")
        ticks = [_values(table, axis) for axis in axes]
        panel.set_yticks(range(len(ticks[0])), [value_text(v) for v in ticks[0]])
        panel.set_xticks(range(len(ticks[1])), [value_text(v) for v in ticks[1]])
        panel.set_ylabel(axes[0])
        panel.set_xlabel(axes[1])
        panel.set_title(title, fontsize=10)
        for (y, x), value in np.ndenumerate(100.0 * values):
            if np.isfinite(value):
                dark = float(norm(value)) < 0.6
                panel.text(
                    x, y, f"{value:.2g}", ha="center", va="center", fontsize=8,
                    color="white" if dark else "black",
                )  # fmt: skip


def _grid(table: Rows, axes: tuple[str, str], column: str) -> Any:
    """A column of the table over two axes, (first, second), NaN where there is none."""
    first, second = (_values(table, axis) for axis in axes)
    grid = np.full((len(first), len(second)), np.nan)
    for row in table:
        value = row.get(column)
        if value is not None:
            grid[first.index(row[axes[0]]), second.index(row[axes[1]])] = value
    return grid


def _values(table: Rows, axis: str) -> list[Any]:
    return sorted({row[axis] for row in table})


def _panels(found: Summary) -> Sequence[tuple[str, list[Found]]]:
    """Detection curves by effect; several panels where they are too many for one."""
    by_effect: dict[str, list[Found]] = {}
    for answer in found.found:
        by_effect.setdefault(answer.effect, []).append(answer)
    return [
        (effect, answers[start : start + _CURVES])
        for effect, answers in by_effect.items()
        for start in range(0, len(answers), _CURVES)
    ]


def _curves(axes: Axes, title: str, answers: Sequence[Found]) -> None:
    """Share of recordings in which the effect is found over its size; 95 % sizes with intervals."""
    for number, answer in enumerate(answers):
        counts = answer.detection
        shares = [100.0 * n / of for n, of in zip(counts.found, counts.of, strict=True)]
        settings = {n: v for n, v in answer.settings.items() if n != "hidden"}
        label = ", ".join(f"{n} {value_text(v)}" for n, v in settings.items())
        (line,) = axes.plot(counts.sizes, shares, "o-", markersize=3.5, linewidth=1.2, label=label)
        if counts.size is not None:
            low = max(counts.low or 0.0, min(counts.sizes))  # open ends stop at what was tried
            high = min(counts.high or np.inf, max(counts.sizes))
            height = 100.0 * counts.share - 3.0 * number
            axes.plot([low, high], [height, height], color=line.get_color(), linewidth=2.5)
            axes.plot([counts.size], [height], "|", color="black", markersize=8)
    axes.axhline(95.0, color="0.6", linewidth=0.8, linestyle=":")
    axes.set_xscale("log")
    sizes = sorted({size for answer in answers for size in answer.detection.sizes})
    axes.set_xticks(sizes, [f"{size:.3g}" for size in sizes])
    axes.minorticks_off()
    unit = f" [{answers[0].unit}]" if answers[0].unit else ""
    axes.set_xlabel(f"{answers[0].what}{unit}")
    axes.set_ylabel("found in % of recordings")
    axes.set_ylim(-4.0, 104.0)
    axes.set_title(title.replace("_", " "), fontsize=10)
    if any(len(answer.settings) > ("hidden" in answer.settings) for answer in answers):
        axes.legend(fontsize=7, loc="lower right")
