"""Figures as inline SVG: one look, no global state left behind, the same bytes every time."""

from __future__ import annotations

import io
import itertools
import re
import textwrap
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup
from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray

from servosight.models.core import Array, rounded, runs_of

Paint = Callable[[Figure], None]

# Okabe and Ito's palette: distinguishable for the colour-blind, and in grey by their line styles.
MEASURED = "#20242a"
BEFORE = "#d55e00"
AFTER = "#0072b2"
SHADE = "#eef1f5"
NOISE = "#b9c2cc"
COMMAND = "#8f9aa5"
FAINT = "#5b6570"

WIDE, NARROW = 8.2, 4.1
"""Widths of figures [inch], on a page and on a telephone."""
WIDE_LETTERS, NARROW_LETTERS = 48, 26
"""Of a line of a legend, beside the others' usual names."""
MANY_DECADES = 1e3
POINTS = 1500
"""Two for each of this many stretches are drawn of a long line: no screen shows more."""

_LOOK: dict[Any, Any] = {
    "svg.fonttype": "none",
    "font.family": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.edgecolor": "#8a939d",
    "axes.labelcolor": FAINT,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e3e7ec",
    "grid.linewidth": 0.7,
    "axes.axisbelow": True,
    "axes.unicode_minus": True,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.major.size": 3.0,
    "ytick.major.size": 3.0,
    "legend.frameon": False,
    "legend.fontsize": 9.0,
    "text.color": MEASURED,
    "figure.facecolor": "none",
    "axes.facecolor": "none",
    "path.simplify": True,
    "path.simplify_threshold": 0.2,
}


def png(size: tuple[float, float], dpi: float, paint: Paint) -> bytes:
    """The same on white as a PNG file, for pages that show no SVG."""
    return _saved(size, paint, _LOOK, dpi=dpi, facecolor="white", metadata={"Software": None})


def drawn(name: str, size: tuple[float, float], alt: str, paint: Paint) -> Markup:
    """What ``paint`` draws on a figure of ``size`` [inch], as SVG; ``alt`` says what it shows.

    ``name`` must differ between the figures of a page: it keeps their ids apart.
    """
    look = {**_LOOK, "svg.hashsalt": name}
    metadata = {"Date": None, "Creator": None}
    return _inlined(_saved(size, paint, look, format="svg", metadata=metadata).decode(), name, alt)


def _saved(size: tuple[float, float], paint: Paint, look: dict[Any, Any], **options: Any) -> bytes:
    """The file that a figure is saved as with these options."""
    with rc_context(look):
        figure = Figure(figsize=size, layout="constrained")
        paint(figure)
        stream = io.BytesIO()
        figure.savefig(stream, **options)
    return stream.getvalue()


def drawn_twice(name: str, height: float, alt: str, paint: Paint) -> Markup:
    """A figure as wide as the page and a narrow one for a telephone: the page shows either."""
    wide = drawn(name, (WIDE, height), alt, paint)
    narrow = drawn(f"{name}-narrow", (NARROW, max(0.85 * height, 0.6 * NARROW)), alt, paint)
    return Markup('<div class="on-wide">{}</div><div class="on-narrow">{}</div>').format(
        wide, narrow
    )


def legend_above(figure: Figure, handles: Sequence[Artist], labels: Sequence[str]) -> None:
    """A legend above the figure, long names on several lines."""
    columns, letters = (4, WIDE_LETTERS) if figure.get_figwidth() > NARROW else (2, NARROW_LETTERS)
    lines = [textwrap.fill(label, letters) for label in labels]
    figure.legend(handles, lines, loc="outside upper left", ncols=columns)


def _inlined(text: str, name: str, alt: str) -> Markup:
    """The svg element alone, its ids prefixed, readable by its alternative text."""
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r'\bid="', f'id="{name}-', text)
    text = re.sub(r"url\(#", f"url(#{name}-", text)
    text = re.sub(r'href="#', f'href="#{name}-', text)
    text = re.sub(r' (?:width|height)="[\d.]+pt"', "", text, count=2)
    label = Markup.escape(alt)
    return Markup(text.replace("<svg ", f'<svg role="img" aria-label="{label}" ', 1))


def thinned(x: Array, *lines: Array) -> list[tuple[Array, Array]]:
    """Each line (samples,) over ``x``, long ones by least and largest value of each stretch."""
    if x.size <= 2 * POINTS:
        return [(x, line) for line in lines]
    edges = np.linspace(0, x.size, POINTS + 1).astype(int)
    found = []
    for line in lines:
        kept = [
            index
            for low, high in itertools.pairwise(edges)
            for index in sorted({low + line[low:high].argmin(), low + line[low:high].argmax()})
        ]
        found.append((x[kept], line[kept]))
    return found


def log_ticks(axis: Axis, low: float, high: float) -> None:
    """Plain numbers on a logarithmic axis; 2 and 5 only where few decades leave room for them."""
    subs = (1.0, 2.0, 5.0) if high < MANY_DECADES * low else (1.0,)
    axis.set_major_locator(LogLocator(subs=subs, numticks=12))
    axis.set_major_formatter(FuncFormatter(lambda value, _: _short(value)))
    axis.set_minor_formatter(NullFormatter())


def _short(value: float) -> str:
    """A number without zeros at its end: ticks within one decade need two digits, others one."""
    text = rounded(value, 2)
    return text.rstrip("0").rstrip(".") if "." in text else text


def shade(axes: Axes, time_s: Array, marked: NDArray[np.bool_]) -> None:
    """Shade the stretches of time where ``marked`` (samples,) is True."""
    for start, stop in runs_of(marked):
        axes.axvspan(time_s[start], time_s[stop - 1], color=SHADE, linewidth=0, zorder=0)
