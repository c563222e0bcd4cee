"""Pictures of the hidden-effect benchmark, from whatever lines there are."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from servosight.models.core import write_bytes
from servosight.models.effects import catalogue

from . import score
from .score import Line

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ONE = ("single", "weak", "faint")
BINS = np.geomspace(0.75, 30.0, 9)
NOTHING, SEVERAL = "nothing", "several"


def pictures(lines: Sequence[Line], folder: Path) -> None:
    """Write all pictures as PNG into ``folder``."""
    from matplotlib.figure import Figure

    folder.mkdir(parents=True, exist_ok=True)
    for name, (draw, size) in _PICTURES.items():
        figure = Figure(figsize=size, layout="constrained")
        draw(figure.subplots(), lines)
        buffer = BytesIO()
        figure.savefig(buffer, format="png", dpi=110, metadata={"Software": None})
        write_bytes(folder / f"{name}.png", buffer.getvalue())


def confusion(axes: Axes, lines: Sequence[Line]) -> None:
    """Rows: what was hidden, strength from 1.5 and separable. Columns: what was named."""
    mine = [x for x in lines if x["row"] in ("single", "weak", "nothing") and score.separable(x)]
    names = list(catalogue())
    hidden = [*names, NOTHING]
    said = [*names, NOTHING, SEVERAL]
    counts = np.zeros((len(hidden), len(said)))
    for line in mine:
        truth = (*score.hidden(line), NOTHING)[0]
        answer = line["named"] or [NOTHING]
        column = answer[0] if len(answer) == 1 else SEVERAL
        if truth in hidden and column in said:
            counts[hidden.index(truth), said.index(column)] += 1
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1.0)
    axes.imshow(shares, cmap="Blues", vmin=0.0, vmax=1.0)
    for (i, j), count in np.ndenumerate(counts):
        if count:
            dark = shares[i, j] > 0.5
            axes.text(j, i, f"{count:.0f}", ha="center", va="center", fontsize=7,
                      color="white" if dark else "black")  # fmt: skip
    axes.set_xticks(range(len(said)), said, rotation=90)
    axes.set_yticks(range(len(hidden)), hidden)
    axes.set_xlabel("named")
    axes.set_ylabel("hidden")


def detection(axes: Axes, lines: Sequence[Line]) -> None:
    """Share named exactly, with Wilson's intervals, in bins of strength."""
    mine = [line for line in lines if line["row"] in ONE and score.separable(line)]
    for low, high in itertools.pairwise(BINS):
        inside = [line for line in mine if low <= line["facts"]["strength"] < high]
        if inside:
            hit = score.share(inside, score.named)
            rate, (least, most) = hit.hits / hit.count, hit.interval
            middle = float(np.sqrt(low * high))
            error = [[max(rate - least, 0.0)], [max(most - rate, 0.0)]]
            axes.errorbar([middle], [rate], error, fmt="o", color="C0", capsize=3)
            axes.annotate(str(hit.count), (middle, 0.02), ha="center", fontsize=8)
    axes.set_xscale("log")
    axes.set_xticks(BINS, [f"{edge:.2g}" for edge in BINS])
    axes.minorticks_off()
    axes.set_ylim(0.0, 1.05)
    axes.set_xlabel("strength: misfit of the linear model over the noise (below: trials)")
    axes.set_ylabel("named exactly")
    axes.grid(alpha=0.3)


def parameters(axes: Axes, lines: Sequence[Line]) -> None:
    """Errors over sigma: other physics, the equation itself, and what a normal law would give."""
    edges = np.linspace(-6.0, 6.0, 49)
    groups: Mapping[str, Callable[[Line], bool]] = {
        "other physics": lambda line: line["row"] in ("single", "weak", "pair", "coarse"),
        "the equation itself": lambda line: line["row"] == "equation",
    }
    for label, chosen in groups.items():
        known = score.parameters([line for line in lines if chosen(line)])
        errors = [(value - truth) / sigma for _, truth, value, sigma in known if sigma]
        if errors:
            axes.hist(np.clip(errors, edges[0], edges[-1]), list(edges), density=True, alpha=0.5,
                      label=f"{label}, {len(errors)}")  # fmt: skip
    axes.plot(edges, np.exp(-0.5 * edges**2) / np.sqrt(2.0 * np.pi), "k--", lw=1, label="normal")
    axes.set_xlabel("(estimate - truth) / sigma; beyond 6 counts as 6")
    axes.legend()


def seconds(axes: Axes, lines: Sequence[Line]) -> None:
    """Processor time of the diagnoses in each row."""
    rows = list(dict.fromkeys(line["row"] for line in lines))
    times = [[line["cpu_s"] for line in lines if line["row"] == row] for row in rows]
    if rows:
        axes.boxplot(times, tick_labels=rows, whis=(5, 95))
        axes.set_yscale("log")
    axes.set_ylabel("processor time of a diagnosis [s]")
    axes.grid(axis="y", alpha=0.3)


_PICTURES = {
    "confusion": (confusion, (8.0, 7.0)),
    "detection": (detection, (7.0, 4.0)),
    "parameters": (parameters, (7.0, 4.0)),
    "time": (seconds, (7.0, 4.0)),
}
