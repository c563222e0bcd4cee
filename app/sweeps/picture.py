"""One picture of a sweep: maps of the errors with their limit beside them, detection by size."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from servosight.app.sweeps.axes import joint_axes
from servosight.app.sweeps.maps import draw_errors
from servosight.models.core import InputError, marked_png, write_bytes
from servosight.scenarios.sweeps import Found, Summary, value_text

CORE = ("k", "T", "xi")
_CURVES = 8
"""Detection curves in one panel; with more, the picture would not be read."""
_DPI = 130


def write_picture(found: Summary, path: Path) -> None:
    """Draw a sweep; InputError where it has nothing to draw."""
    panels = list(_panels(found))
    axes = joint_axes(found)
    able = not panels and found.table and len(axes) <= 2
    errors = [name for name in CORE if f"{name}_error" in found.table[0]] if able else []
    if not errors and not panels:
        raise InputError(
            f"{path}: this sweep has no errors over one or two axes and no sizes of effects, "
            f"expected one of them to draw; print it without --plot, or choose .html"
        )
    columns = 1 if len(panels) == 1 or (errors and len(axes) == 1) else 2
    rows = max(len(errors), -(-len(panels) // columns))
    figure = Figure(figsize=(4.8 * max(columns, 1.5), 3.3 * rows + 0.4), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(rows, columns, squeeze=False)
    for row, name in zip(grid, errors, strict=False):
        draw_errors(row, found.table, axes, name)
    for panel, (title, answers) in zip(grid.flat, panels, strict=False):
        _curves(panel, title, answers)
    for panel in grid.flat[len(panels) :] if panels else ():
        panel.set_visible(False)
    figure.suptitle(found.about or found.name, fontsize=11)
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=_DPI)
    write_bytes(path, marked_png(data.getvalue()))


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
