"""Figures 11 to 16: parameters and error over the generations, for the three algorithms."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from servosight.app.report.figure import AFTER, BEFORE, FAINT, MEASURED, NOISE

from .page import picture, table
from .search_counts import ALGORITHMS
from .system_model import GENERATIONS, NAMES, TRUE, errors, paths, record

KEYS = {"genetic algorithm": "ga", "particle swarm": "pso", "combination": "combination"}
COLOURS = (AFTER, BEFORE, MEASURED, FAINT)
SHOWN = (5, 10, 20, 50, 100)
SEEDS = range(50)


def figures() -> str:
    """The picture, and the errors of 50 seeds as a table."""
    runs = {
        name: np.array([errors(paths(KEYS[name], seed, record(seed))) for seed in SEEDS])
        for name in ALGORITHMS
    }
    floor = [np.linalg.norm(record(seed).least_squares - TRUE) for seed in SEEDS]
    generation = np.arange(1, GENERATIONS + 1)

    def paint(figure: Figure) -> None:
        panels = figure.subplots(len(runs), 2, sharex=True, sharey="col")
        for number, (name, found) in enumerate(runs.items()):
            left, right = panels[number]
            path = paths(KEYS[name], 0, record(0))
            for j, colour in enumerate(COLOURS):
                left.axhline(TRUE[j], color=NOISE, linestyle=":")
                left.plot(generation, path[:, j], color=colour, label=NAMES[j])
            left.set_ylabel("parameters")
            left.set_title(f"Fig. {11 + 2 * number}: {name}", fontsize=9, loc="left")
            low, middle, high = np.percentile(found, (10, 50, 90), axis=0)
            right.fill_between(generation, low, high, color=NOISE, linewidth=0, alpha=0.6)
            right.plot(generation, middle, color=AFTER)
            right.axhline(float(np.median(floor)), color=BEFORE, linestyle="--")
            right.set_yscale("log")
            right.set_ylabel("error")
            right.set_title(f"Fig. {12 + 2 * number}: {name}", fontsize=9, loc="left")
        lines, names = panels[0, 0].get_legend_handles_labels()
        figure.legend(lines, names, loc="outside lower center", ncols=4)
        for axes in panels[-1]:
            axes.set_xlabel("generation")

    alt = "Parameters and error over the generations, for three algorithms"
    rows = [
        [name, *(f"{np.median(lines[:, at - 1]):.3f}" for at in SHOWN)]
        for name, lines in runs.items()
    ]
    rows.append(["least squares", *[f"{np.median(floor):.3f}"] * len(SHOWN)])
    head = ["median error after generation", *map(str, SHOWN)]
    return picture("system", (8.0, 7.5), alt, paint) + "\n\n" + table(head, rows)
