"""The servo in a control engineer's figures: Bode plot, bandwidth, response to a step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

from servosight.app.report.figure import AFTER, BEFORE, FAINT, NOISE, drawn
from servosight.app.report.section import Section
from servosight.app.report.story import Story
from servosight.diagnose import Comparison, listed
from servosight.models.core import Actuator, Array, Estimate, rounded
from servosight.models.effects import Effect
from servosight.models.plant import (
    StepMetrics,
    bandwidth_hz,
    natural_frequency_hz,
    resonance_db,
    step_metrics,
)

SIZE = (3.9, 3.3)
LOOKS = ((BEFORE, "--"), (AFTER, "-"))
POINTS = 2001
LENGTH = 12.0
"""The step response is drawn over so many time constants, of the slow pole where there are two;"""
BEFORE_STEP = 0.05
"""and this share of it before the step."""
STEP_SHARE = 0.25
"""The step is this share of the command's range: within what the recordings have used."""


def section(story: Story) -> Section:
    """Of the models' linear cores, and of the models as a whole."""
    models = _models(story)
    size_deg = STEP_SHARE * max(float(np.ptp(one.command_deg)) for one in story.recordings)
    time_s = _times(models[0][1])
    responses = [_response(actuator, time_s, size_deg, story.catalogue) for _, actuator in models]
    return Section(
        "dynamics",
        "Bode plot and step response",
        {
            "rows": [_row(name, actuator) for name, actuator in models],
            "steps": [
                (name, _metrics(time_s, angle))
                for (name, _), angle in zip(models, responses, strict=True)
            ],
            "size_deg": size_deg,
            "figures": [_bode(models), _step(models, time_s, responses, size_deg)],
            "models": [name for name, _ in models],
        },
    )


def _models(story: Story) -> list[tuple[str, Actuator]]:
    """Name and actuator of the model that the story begins with, and of the one it ends with."""
    result = story.result
    if isinstance(result, Comparison):
        return [("model", result.actuator)]
    linear = result.ladder[0]
    core = {one: Estimate(linear.value(one), None, "") for one in ("k", "T", "xi", "bias")}
    models = [("linear model", Actuator(core))]
    if result.effects and len(result.ladder) > 1:
        models.append((f"with {listed(result.effects)}", result.actuator))
    return models


def _row(name: str, actuator: Actuator) -> dict[str, Any]:
    k, T, xi = (actuator.value(one) for one in ("k", "T", "xi"))
    return {
        "name": name,
        "gain": k,
        "natural_hz": natural_frequency_hz(T),
        "damping": xi,
        "bandwidth_hz": bandwidth_hz(T, xi),
        "resonance_db": resonance_db(xi),
    }


def _times(actuator: Actuator) -> Array:
    T, xi = actuator.value("T"), actuator.value("xi")
    slow_s = T * (xi + np.sqrt(xi * xi - 1.0)) if xi > 1.0 else T / max(xi, 0.2)
    return np.linspace(-BEFORE_STEP, 1.0, POINTS) * LENGTH * slow_s


def _response(
    actuator: Actuator, time_s: Array, size_deg: float, catalogue: Mapping[str, Effect]
) -> Array:
    """The angle [deg] after a step of the command at time 0, from where it rests before."""
    command = np.where(time_s < 0.0, 0.0, size_deg)
    angle = actuator.predict(time_s=time_s - time_s[0], command_deg=command, catalogue=catalogue)
    return np.asarray(angle - angle[time_s < 0.0][-1])


def _metrics(time_s: Array, angle_deg: Array) -> StepMetrics:
    later = time_s >= 0.0
    return step_metrics(time_s[later], angle_deg[later])


def _bode(models: Sequence[tuple[str, Actuator]]) -> Markup:
    """Gain and phase of the linear cores, analytically, with natural frequency and bandwidth."""
    last = models[-1][1]
    middle = natural_frequency_hz(last.value("T"))
    at = np.geomspace(0.03 * middle, 30.0 * middle, 400)

    def paint(figure: Figure) -> None:
        gains, phases = figure.subplots(2, 1, sharex=True)
        for (name, actuator), (colour, look) in zip(models, LOOKS, strict=False):
            k, T, xi = (actuator.value(one) for one in ("k", "T", "xi"))
            s = 2j * np.pi * at
            response = k / (T * T * s * s + 2.0 * xi * T * s + 1.0)
            style = {"color": colour, "linewidth": 1.3}
            gains.semilogx(at, 20.0 * np.log10(np.abs(response)), look, label=name, **style)
            turned = 180.0 if k < 0.0 else 0.0
            phases.semilogx(at, np.degrees(np.unwrap(np.angle(response))) - turned, look, **style)
        marks = (
            (middle, "natural frequency"),
            (bandwidth_hz(last.value("T"), last.value("xi")), "bandwidth (−3 dB)"),
        )
        for (frequency, words), line in zip(marks, (":", "-."), strict=True):
            for axes in (gains, phases):
                axes.axvline(frequency, color=FAINT, linestyle=line, linewidth=0.9)
            gains.plot([], [], color=FAINT, linestyle=line, linewidth=0.9, label=words)
        gains.set_ylabel("gain [dB]")
        phases.set_ylabel("phase [deg]")
        phases.set_xlabel("frequency [Hz]")
        phases.set_yticks([0, -45, -90, -135, -180])
        phases.xaxis.set_major_formatter(FuncFormatter(lambda value, _: rounded(value, 1)))
        phases.xaxis.set_minor_formatter(NullFormatter())
        gains.legend(loc="lower left", fontsize=7.5)
        figure.align_ylabels()

    return drawn("dynamics-bode", SIZE, "Bode plot of the linear core: gain and phase.", paint)


def _step(
    models: Sequence[tuple[str, Actuator]],
    time_s: Array,
    responses: Sequence[Array],
    size_deg: float,
) -> Markup:
    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        command = np.where(time_s < 0.0, 0.0, size_deg)
        axes.plot(time_s, command, color=NOISE, linewidth=1.1, label="command")
        for (name, _), angle, (colour, look) in zip(models, responses, LOOKS, strict=False):
            axes.plot(time_s, angle, look, color=colour, linewidth=1.3, label=name)
        axes.set_xlim(time_s[0], time_s[-1])
        axes.set_xlabel("time after the step [s]")
        axes.set_ylabel("angle [deg]")
        axes.legend(loc="lower right", fontsize=7.5)

    alt = f"Response to a step of the command by {size_deg:.3g} deg."
    return drawn("dynamics-step", SIZE, alt, paint)
