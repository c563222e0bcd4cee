"""What differs between two servos, as sections of a page: the result of ``compare A B``."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullLocator

from servosight.app.report.figure import AFTER, FAINT, SHADE, drawn_twice
from servosight.app.report.section import Section
from servosight.app.report.sections.model.dynamics import dynamics_of
from servosight.diagnose.change import (
    STEP_DEG,
    ComparedServo,
    ParameterChange,
    ServoChange,
    limit_sigmas,
)
from servosight.models.core import Actuator, Estimate, rounded, signed
from servosight.models.effects import Effect

ROW = 0.42
"""Height of the figure for each parameter [inch]."""


def sections(result: ServoChange, catalogue: Mapping[str, Effect]) -> list[Section]:
    """What changed, each parameter in both, and how the two servos move."""
    names = side_names(result)
    models = [
        (name, model, side.dynamics)
        for name, model, side in zip(names, _models(result), (result.a, result.b), strict=True)
        if side.dynamics is not None
    ]
    return [
        Section(
            "change",
            result.headline,
            {
                "summary": result.summary,
                "causes": result.sentences[len(result.changed) :],
                "warnings": result.warnings,
                "sides": [
                    (name, side)
                    for name, side in zip(names, (result.a, result.b), strict=True)
                    if side.rmse_deg is not None
                ],
            },
        ),
        Section(
            "differences",
            "Each parameter in both",
            {
                "names": names,
                "rows": result.parameters,
                "figure": _figure(result),
                "limit": limit_sigmas(len(result.parameters)),
                "p": result.p,
            },
        ),
        dynamics_of(models, STEP_DEG, catalogue),
    ]


def side_names(result: ServoChange) -> list[str]:
    """What the sides are called, and which is which: they may be called the same."""
    return [
        f"{side}: {', '.join(one.recordings) or one.name if one.name == side else one.name}"
        for side, one in zip("ab", (result.a, result.b), strict=True)
    ]


def _models(result: ServoChange) -> list[Actuator]:
    """The two models, of the values that were compared."""
    rows = result.parameters
    return [
        _model(result.a, [(one, one.a, one.a_sigma) for one in rows if one.only_in != "b"]),
        _model(result.b, [(one, one.b, one.b_sigma) for one in rows if one.only_in != "a"]),
    ]


def _model(
    side: ComparedServo, given: Iterable[tuple[ParameterChange, float | None, float | None]]
) -> Actuator:
    """A side's model; its bias, which belongs to the mounting, was not compared."""
    values = {
        row.name: Estimate(value, sigma, row.unit)
        for row, value, sigma in given
        if value is not None
    }
    return Actuator({**values, "bias": Estimate(0.0, None, "deg")}, side.effects)


def _figure(result: ServoChange) -> Markup | None:
    """Each difference in multiples of its sigma; None where no sigma is known."""
    rows = [one for one in result.parameters if one.sigmas is not None]
    if not rows:
        return None
    limit = limit_sigmas(len(result.parameters))
    values = np.array([float(one.sigmas or 0.0) for one in rows])
    reach = 1.6 * max(limit, float(np.abs(values).max()))

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        axes.set_xscale("symlog", linthresh=limit, linscale=2.0)
        axes.axvspan(-limit, limit, color=SHADE, zorder=0)
        axes.axvline(0.0, color=FAINT, linewidth=0.8)
        for place, (one, value) in enumerate(zip(rows, values, strict=True)):
            colour = AFTER if one.changed else FAINT
            axes.plot([0.0, value], [place, place], color=colour, linewidth=1.3)
            axes.plot(value, place, "o", color=colour, markersize=5.0)
        axes.set_xlim(-reach, reach)
        ticks = [tick for tick in (0, 2, 10, 100, 1000, 10000) if tick < reach]
        axes.set_xticks([*(-tick for tick in reversed(ticks[1:])), *ticks])
        axes.xaxis.set_minor_locator(NullLocator())
        axes.xaxis.set_major_formatter(
            FuncFormatter(lambda value, _: signed(value, 0) if value else "0")
        )
        axes.set_yticks(range(len(rows)), [one.name for one in rows])
        axes.set_ylim(len(rows) - 0.4, -0.6)
        axes.set_xlabel("b less a, in sigmas")

    words = (f"{one.name} {rounded(value, 2)}" for one, value in zip(rows, values, strict=True))
    alt = f"Differences in sigmas: {', '.join(words)}."
    return drawn_twice("differences", 0.9 + ROW * len(rows), alt, paint)
