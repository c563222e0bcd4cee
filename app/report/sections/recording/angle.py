"""Measured and predicted angle over time, and the error before and after."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from markupsafe import Markup
from matplotlib.figure import Figure
from numpy.typing import NDArray

from servosight.app.report.figure import (
    AFTER,
    BEFORE,
    COMMAND,
    FAINT,
    MEASURED,
    NOISE,
    Paint,
    drawn_twice,
    legend_above,
    shade,
    thinned,
)
from servosight.app.report.section import Section
from servosight.app.report.story import Story
from servosight.diagnose.residuals import TEST, Window
from servosight.models.core import Array, Mask, degrees, rms

MOST_RECORDINGS = 4
MARGIN_S = 0.35
BAND = 2.0
"""The noise band is as many standard deviations wide to either side: 19 in 20 samples."""
MOST_RATIO = 4.0
COLOURS = (BEFORE, AFTER)
STYLES = ("--", "-")


def section(story: Story) -> Section:
    """The whole of each recording, then the worst window of the worst one."""
    order = sorted(range(len(story.recordings)), key=lambda i: (i != story.worst, i))
    wholes: list[dict[str, Any]] = [
        {"name": story.names[i], "figure": _figure(story, i, None)}
        for i in sorted(order[:MOST_RECORDINGS])
    ]
    close = None
    if story.where:
        window = story.where[0]
        close = {
            "window": window,
            "figure": _figure(story, story.worst, _surrounded(window)),
        }
    return Section(
        "angle",
        "Measured and predicted",
        {
            "wholes": wholes,
            "left_out": len(order) - len(wholes),
            "close": close,
            "models": [model.name for model in story.models],
            "noise_deg": story.noise_deg,
            "band": BAND,
            "pushed": _pushed(story, range(len(story.recordings))),
            "blocks": any(_held_out(story, i).any() for i in order),
        },
    )


def _held_out(story: Story, number: int) -> NDArray[np.bool_]:
    """The samples held out; none where that would be all of them."""
    one = story.before.judged[number]
    split = np.unique(one.uses).size > 1
    return np.asarray(one.uses == TEST if split else np.zeros(one.uses.size, dtype=bool))


def _pushed(story: Story, numbers: Iterable[int]) -> bool:
    """True where one of the recordings has a known disturbance."""
    return any(story.recordings[i].disturbance_unit is not None for i in numbers)


def _figure(story: Story, number: int, span_s: tuple[float, float] | None) -> Markup:
    """Angle above, error below, then a known disturbance; ``span_s`` cuts out a window."""
    close = span_s is not None
    low, high, seen = _window(story, number, span_s)
    pushed = _pushed(story, [number])
    where = f"from {low:.2f} to {high:.2f} s" if close else "over the whole recording"
    errors = ", ".join(
        f"{model.name}: {degrees(rms(model.judged[number].error_deg[seen]))} rms"
        for model in story.models
    )
    below = ", the error and the known disturbance below" if pushed else ", and the error below"
    alt = f"Measured and predicted angle {where}{below}. Error of the {errors}."
    name = f"angle-{number}{'-close' if close else ''}"
    return drawn_twice(name, 5.4 if pushed else 4.4, alt, painted(story, number, span_s))


def worst_moment(story: Story) -> Paint:
    """What draws the worst window of the worst recording, with its surroundings."""
    return painted(story, story.worst, _surrounded(story.where[0]))


def _surrounded(window: Window) -> tuple[float, float]:
    return window.start_s - MARGIN_S, window.end_s + MARGIN_S


def _window(
    story: Story, number: int, span_s: tuple[float, float] | None
) -> tuple[float, float, Mask]:
    """Its ends [s], and the samples within; of the whole recording where there is no span."""
    time_s = story.recordings[number].time_s
    low, high = (float(time_s[0]), float(time_s[-1])) if span_s is None else span_s
    return low, high, np.asarray((time_s >= low) & (time_s <= high))


def painted(story: Story, number: int, span_s: tuple[float, float] | None) -> Paint:
    """What draws the figure of one recording."""
    recording = story.recordings[number]
    pushed = _pushed(story, [number])
    time_s = recording.time_s
    low, high, seen = _window(story, number, span_s)
    close = span_s is not None

    def paint(figure: Figure) -> None:
        panels = figure.subplots(2 + pushed, 1, sharex=True, height_ratios=(6, 4, 3)[: 2 + pushed])
        upper, lower = panels[:2]
        for axes in panels:
            axes.set_xlim(max(low, time_s[0]), min(high, time_s[-1]))
            shade(axes, time_s[seen], _held_out(story, number)[seen])
        (line,) = thinned(time_s[seen], recording.angle_deg[seen])
        ((command_time, command),) = thinned(*_command(story, number, low, high))
        scaled = _own_scale(command, line[1])
        (upper.twinx() if scaled else upper).plot(
            command_time,
            command,
            color=COMMAND,
            linewidth=1.0,
            label="command, right-hand scale" if scaled else "command",
        )
        if close:
            upper.plot(*line, ".", color=MEASURED, markersize=4.5, label="measured")
        else:
            # Wide enough to be seen on both sides of a model that lies on it.
            upper.plot(*line, color=MEASURED, linewidth=2.2, label="measured")
        lower.axhspan(
            -BAND * story.noise_deg, BAND * story.noise_deg, color=NOISE, alpha=0.6, linewidth=0
        )
        for model, colour, style in zip(story.models, COLOURS, STYLES, strict=False):
            one = model.judged[number]
            angle, error = thinned(time_s[seen], one.predicted_deg[seen], one.error_deg[seen])
            upper.plot(*angle, style, color=colour, linewidth=1.1, label=model.name)
            lower.plot(*error, color=colour, linewidth=1.0 if close else 0.7)
        upper.set_ylabel("angle [deg]")
        lower.set_ylabel("error [deg]")
        handles = [h for axes in figure.axes for h in axes.lines if axes is not lower]
        if pushed:
            (push,) = thinned(time_s[seen], recording.disturbance_at(time_s[seen]))
            panels[-1].plot(*push, color=FAINT, linewidth=1.0, drawstyle="steps-post")
            panels[-1].set_ylabel(f"disturbance [{recording.disturbance_unit}]")
        panels[-1].set_xlabel("time [s]")
        labels = [str(handle.get_label()) for handle in handles]
        legend_above(figure, handles, labels)
        figure.align_ylabels(panels)

    return paint


def _own_scale(command: Array, angle: Array) -> bool:
    """True where command and angle differ so much in size that one scale would hide either."""
    ratio = float(np.ptp(command)) / max(float(np.ptp(angle)), 1e-12)
    return not 1.0 / MOST_RATIO < ratio < MOST_RATIO


def _command(story: Story, number: int, low: float, high: float) -> tuple[Array, Array]:
    """The command as the servo got it within a window: stairs where it is held."""
    recording = story.recordings[number]
    times, values = recording.command_time_s, recording.command_deg
    if recording.hold == "zero":
        times, values = np.repeat(times, 2)[1:], np.repeat(values, 2)[:-1]
    inside = (times > low) & (times < high)
    first, last = recording.command_at(np.array([low, high]))
    return (
        np.concatenate([[low], times[inside], [high]]),
        np.concatenate([[first], values[inside], [last]]),
    )
