"""The torque that no catalogued effect explains, and the law that was found for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from servosight.app.report.figure import AFTER, BEFORE, MEASURED, NOISE, drawn
from servosight.app.report.section import Section
from servosight.app.report.story import Story
from servosight.diagnose import Diagnosis, phrased
from servosight.diagnose.discrepancy import Law, MissingTorque
from servosight.models.core import Array

SIZE = (2.75, 2.4)
BINS = 40
DOTS = 1200
ACROSS: Mapping[str, tuple[str, Callable[[MissingTorque], Array]]] = {
    "angle": ("angle [deg]", lambda one: one.angle_deg),
    "speed": ("speed [deg/s]", lambda one: one.speed_deg_s),
    "time": ("time from the first sample [s]", lambda one: one.time_s),
}
"""What the torque is drawn against: label and values."""


def section(story: Story) -> Section | None:
    """None where no law was found."""
    result = story.result
    if not isinstance(result, Diagnosis) or result.law is None:
        return None
    law = result.law
    return Section(
        "law",
        "A law for what remains",
        {
            "sentence": law.sentence,
            "terms": [(term.words, term.equation) for term in law.terms],
            "coefficients": law.coefficients,
            "before_deg": law.held_out_before_deg,
            "after_deg": law.held_out_after_deg,
            "floor_deg": law.floor_deg,
            "base": f"model with {phrased(law.added_to)}" if law.added_to else "linear model",
            "figures": [_against(law, what) for what in ACROSS],
        },
    )


def _against(law: Law, what: str) -> Markup:
    """The missing torque before as dots and bin means, and after as bin means."""

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        read = ACROSS[what][1]
        x = np.concatenate([read(one) for one in law.missing])
        torque = np.concatenate([one.torque_deg for one in law.missing])
        left = np.concatenate([one.left_deg for one in law.missing])
        sigma = max(one.sigma_deg for one in law.missing)
        axes.axhspan(-sigma, sigma, color=NOISE, alpha=0.6, linewidth=0)
        few = np.linspace(0, x.size - 1, min(DOTS, x.size)).astype(int)
        axes.plot(x[few], torque[few], ".", color=MEASURED, markersize=1.5, alpha=0.4)
        means = [
            _means(axes, x, torque, BEFORE, "o--"),
            _means(axes, x, left, AFTER, "s-"),
        ]
        # A few instants far off would press all else into a line.
        shown = np.concatenate([*means, np.quantile(torque, [0.005, 0.995])])
        room = 0.08 * float(np.ptp(shown))
        axes.set_ylim(float(shown.min()) - room, float(shown.max()) + room)
        axes.set_xlabel(ACROSS[what][0])
        axes.set_ylabel("missing torque [deg]")

    alt = f"The missing torque against {what}, before and after the law."
    return drawn(f"law-{what}", SIZE, alt, paint)


def _means(axes: Axes, x: Array, torque: Array, colour: str, look: str) -> Array:
    """Draw means over equally filled bins, and return them."""
    parts = np.array_split(np.argsort(x, kind="stable"), min(BINS, x.size))
    means = np.array([(x[part].mean(), torque[part].mean()) for part in parts])
    axes.plot(means[:, 0], means[:, 1], look, color=colour, markersize=3, linewidth=1.2)
    return means[:, 1]
