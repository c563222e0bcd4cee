"""The servo in a control engineer's figures: Bode plot, bandwidth, response to a step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

from servosight.app.report.figure import AFTER, BEFORE, COMMAND, FAINT, drawn
from servosight.app.report.section import Section
from servosight.app.report.story import Story, compared_model
from servosight.diagnose import Comparison, named_model, phrased
from servosight.identify.fit import Dynamics, dynamics, step_response, step_size_deg, step_times
from servosight.models.core import Actuator, Array, Estimate, rounded, uncertain
from servosight.models.effects import Effect
from servosight.models.plant import bandwidth_hz, natural_frequency_hz

SIZE = (3.9, 3.3)
LOOKS = ((BEFORE, "--"), (AFTER, "-"))
CORE_FIGURES = ("natural_frequency_hz", "bandwidth_hz", "resonance_db")
STEP_FIGURES = ("rise_time_s", "overshoot", "settling_time_s", "final_change_deg")
SHOWN = {"rise_time_s": (1e3, "ms"), "settling_time_s": (1e3, "ms"), "overshoot": (100.0, "%")}
"""Factor and unit of what is shown in another unit than it is saved in."""
NO_PEAK_DB = 1e-9

Named = tuple[str, Actuator, Dynamics]


def section(story: Story) -> Section:
    """Of the models' linear cores, and of the models as a whole."""
    models = _models(story)
    return dynamics_of(models, models[-1][2].step_deg, story.catalogue)


def dynamics_of(
    models: Sequence[Named], size_deg: float, catalogue: Mapping[str, Effect]
) -> Section:
    """Of one or two models: name, model, and its figures for a step of ``size_deg``."""
    time_s = step_times(models[0][1])
    responses = [step_response(one, time_s, size_deg, catalogue) for _, one, _ in models]
    return Section(
        "dynamics",
        "Bode plot and step response",
        {
            "cores": [(name, _core(actuator, found)) for name, actuator, found in models],
            "steps": [(name, _cells(found, STEP_FIGURES)) for name, _, found in models],
            "size_deg": size_deg,
            "figures": [_bode(models), _step(time_s, responses, size_deg)],
        },
    )


def _models(story: Story) -> list[Named]:
    """The model that the story begins with, and the one it ends with: name, model, figures.

    The figures are of one step of the command, that of the diagnosis: a recording that only tests
    may have moved farther than those that were fitted.
    """
    result = story.result
    size_deg = step_size_deg(story.recordings)
    if isinstance(result, Comparison):
        model = compared_model(result, story.catalogue)
        return [("model", model, _unsure(story, model, size_deg))]
    saved = result.ladder[-1].dynamics
    size_deg = size_deg if saved is None else saved.step_deg
    named = [(named_model(result.ladder[0].effects, result.ladder[0].base), result.ladder[0])]
    if len(result.ladder) > 1:
        named.append((f"with {phrased(result.ladder[-1].effects)}", result.ladder[-1]))
    return [
        (
            name,
            step.actuator,
            step.dynamics or _unsure(story, step.actuator, size_deg),
        )
        for name, step in named
    ]


def _unsure(story: Story, actuator: Actuator, size_deg: float) -> Dynamics:
    """Without sigmas: of a model card no covariance is known."""
    return dynamics(actuator, None, size_deg, story.catalogue)


def _core(actuator: Actuator, found: Dynamics) -> list[str]:
    k, xi = (_cell(actuator.parameters[name]) for name in ("k", "xi"))
    natural, bandwidth, resonance = _cells(found, CORE_FIGURES)
    if found.resonance_db.value <= NO_PEAK_DB:
        resonance = "none"
    return [k, natural, xi, bandwidth, resonance]


def _cells(found: Dynamics, names: Sequence[str]) -> list[str]:
    return [_cell(getattr(found, name), *SHOWN.get(name, (1.0, None))) for name in names]


def _cell(one: Estimate | None, factor: float = 1.0, unit: str | None = None) -> str:
    """A value with its sigma, where that is known; the unit behind."""
    if one is None:
        return "–"
    shown = one.unit if unit is None else unit
    sigma = None if one.sigma is None else factor * one.sigma
    value, spread = uncertain(factor * one.value, sigma)
    words = f"{value} ± {spread}" if sigma else value
    return words if shown == "-" else f"{words} {shown}"


def _bode(models: Sequence[Named]) -> Markup:
    """Gain and phase of the linear cores, analytically, with natural frequency and bandwidth."""
    last = models[-1][1]
    middle = natural_frequency_hz(last.value("T"))
    at = np.geomspace(0.03 * middle, 30.0 * middle, 400)

    def paint(figure: Figure) -> None:
        gains, phases = figure.subplots(2, 1, sharex=True)
        for (_, actuator, _), (colour, look) in zip(models, LOOKS, strict=False):
            response = actuator.linear_response(at)
            style = {"color": colour, "linewidth": 1.3}
            gains.semilogx(at, 20.0 * np.log10(np.abs(response)), look, **style)
            turned = 180.0 if actuator.value("k") < 0.0 else 0.0
            phases.semilogx(at, np.degrees(np.unwrap(np.angle(response))) - turned, look, **style)
        marks = (middle, ":"), (bandwidth_hz(last.value("T"), last.value("xi")), "--")
        for axes in (gains, phases):
            for frequency, line in marks:
                axes.axvline(frequency, color=FAINT, linestyle=line, linewidth=1.1)
        gains.set_ylabel("gain [dB]")
        phases.set_ylabel("phase [deg]")
        phases.set_xlabel("frequency [Hz]")
        phases.set_yticks([0, -45, -90, -135, -180])
        phases.xaxis.set_major_formatter(FuncFormatter(lambda value, _: rounded(value, 1)))
        phases.xaxis.set_minor_formatter(NullFormatter())
        figure.align_ylabels()

    return drawn("dynamics-bode", SIZE, "Bode plot of the linear core: gain and phase.", paint)


def _step(time_s: Array, responses: Sequence[Array], size_deg: float) -> Markup:
    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        command = np.where(time_s < 0.0, 0.0, size_deg)
        axes.plot(time_s, command, color=COMMAND, linewidth=1.0)
        for angle, (colour, look) in zip(responses, LOOKS, strict=False):
            axes.plot(time_s, angle, look, color=colour, linewidth=1.3)
        axes.set_xlim(time_s[0], time_s[-1])
        axes.set_xlabel("time after the step [s]")
        axes.set_ylabel("angle [deg]")

    alt = f"Response to a step of the command by {size_deg:.3g} deg."
    return drawn("dynamics-step", SIZE, alt, paint)
