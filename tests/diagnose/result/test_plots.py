"""Plots of a diagnosis: what stands side by side can be read."""

from __future__ import annotations

import itertools

from matplotlib.figure import Figure

from servosight.diagnose.result._plots import plot_ladder


def test_the_names_of_five_steps_stand_beside_each_other() -> None:
    names = ("linear", "+ velocity feedforward", "+ Coulomb friction", "+ integral action")
    steps = {
        f"{place}: {name}": 0.5 for place, name in enumerate((*names, "- velocity feedforward"))
    }
    figure = Figure()
    axes = plot_ladder(steps, 0.03, figure.subplots())
    figure.canvas.draw()
    boxes = [label.get_window_extent() for label in axes.get_xticklabels()]
    assert len(boxes) == 5
    for left, right in itertools.pairwise(boxes):
        assert left.x1 < right.x0
