"""The torque that no catalogued effect accounts for, and the law that was found for it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from servosight.app.report.figure import AFTER, BEFORE, MEASURED, NOISE, drawn
from servosight.app.report.section import Section
from servosight.app.report.story import Story, listed
from servosight.diagnose import Diagnosis
from servosight.diagnose.discrepancy import Law, Missing, missing_torque
from servosight.diagnose.discrepancy.basis import Motion
from servosight.models.core import Array

SIZE = (2.75, 2.4)
BINS = 40
DOTS = 1200
ACROSS: Mapping[str, tuple[str, Callable[[Motion], Array]]] = {
    "angle": ("angle [deg]", lambda motion: motion.angle_deg),
    "speed": ("speed [deg/s]", lambda motion: motion.speed_deg_s),
    "time": ("time from the first sample [s]", lambda motion: motion.time_s),
}
"""What the torque is drawn against: label and values."""


def section(story: Story) -> Section | None:
    """None where the ladder left nothing that a law explains."""
    result = story.result
    if not isinstance(result, Diagnosis) or result.law is None:
        return None
    law = result.law
    return Section(
        "law",
        "What nobody has named yet",
        {
            "sentence": law.sentence,
            "terms": [(form.words, form.effect.equation) for form in law.terms],
            "coefficients": law.coefficients,
            "before_deg": law.before.held_out_rmse_deg,
            "after_deg": law.after.held_out_rmse_deg,
            "floor_deg": law.floor_deg,
            "base": f"model with {listed(law.base.effects)}"
            if law.base.effects
            else "linear model",
            "figures": [_against(law, result.noise_deg, what) for what in ACROSS],
        },
    )


def _against(law: Law, noise_deg: float, what: str) -> Markup:
    """The missing torque before as dots and bin means, and after as bin means."""
    left = missing_torque(law.after, len(law.missing), noise_deg)

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        x, torque = _joined(law.missing, what)
        sigma = max(one.sigma_deg for one in law.missing)
        axes.axhspan(-sigma, sigma, color=NOISE, alpha=0.6, linewidth=0)
        few = np.linspace(0, x.size - 1, min(DOTS, x.size)).astype(int)
        axes.plot(x[few], torque[few], ".", color=MEASURED, markersize=1.5, alpha=0.4)
        _means(axes, x, torque, BEFORE, "o--")
        _means(axes, *_joined(left, what), AFTER, "s-")
        axes.set_xlabel(ACROSS[what][0])
        axes.set_ylabel("missing torque [deg]")

    alt = f"The missing torque against {what}, before and after the law."
    return drawn(f"law-{what}", SIZE, alt, paint)


def _joined(missing: Sequence[Missing], what: str) -> tuple[Array, Array]:
    """What lies across, and the torque, of all recordings end to end."""
    read = ACROSS[what][1]
    across = np.concatenate([read(one.motion) for one in missing])
    return across, np.concatenate([one.torque_deg for one in missing])


def _means(axes: Axes, x: Array, torque: Array, colour: str, look: str) -> None:
    """Means over equally filled bins."""
    parts = np.array_split(np.argsort(x, kind="stable"), min(BINS, x.size))
    means = np.array([(x[part].mean(), torque[part].mean()) for part in parts])
    axes.plot(means[:, 0], means[:, 1], look, color=colour, markersize=3, linewidth=1.2)
