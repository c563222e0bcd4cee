"""Section E: video of a sine, the difference equation and back, and what a sine cannot identify."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from servosight.app.report.figure import AFTER, BEFORE, FAINT
from servosight.identify.discrete._discrete import to_linear
from servosight.identify.fit import Solution, identify
from servosight.models.core import Recording
from servosight.models.effects import catalogue
from servosight.models.plant import Difference, Linear, to_difference
from servosight.scenarios.produce import produce
from servosight.scenarios.settings import CommandSettings
from servosight.sources import read

from .actuator_model import (
    PRINTED,
    RICH,
    SINE,
    TRUE,
    made,
    scenario,
    settled,
    with_T_fixed,
)
from .page import picture, table

TIMES_S = (0.001, 0.002, 0.004, 0.0078, 0.012, 0.016, 0.02)
TEMPLATE_DEG = 0.02
"""What matching an unrotated template on a textured fin scatters by; see docs/tracking.md."""
SEEDS = range(20)
MOTIONS: dict[str, CommandSettings] = {"20 deg, 1 Hz sine": SINE, "servosight's standard": RICH}


def conversion() -> str:
    """The printed numbers against each other, under three transforms."""
    head = ["", "a1", "a2", "b0", "b1", "b2", "k", "T [ms]", "xi"]
    true = Linear(TRUE.k, TRUE.T, TRUE.xi)
    corrected = Difference(0.01, PRINTED.a1, PRINTED.a2, PRINTED.b0, 0.395, PRINTED.b2)
    rows = [
        line("printed, by Tustin's rule at 10 ms", PRINTED, to_linear(PRINTED)),
        line("b1 = 0.395 instead", corrected, to_linear(corrected)),
    ]
    rows += [
        line(f"printed k, T, xi by {name}", to_difference(true, 0.01, transform), true)
        for name, transform in (
            ("Tustin's rule", "tustin"),
            ("zero-order hold", "zoh"),
            ("matched poles", "matched"),
        )
    ]
    return table(head, rows)


def line(name: str, one: Difference, linear: Linear) -> list[str]:
    """A row of coefficients and parameters."""
    coefficients = (one.a1, one.a2, one.b0, one.b1, one.b2)
    return [
        name,
        *(f"{x:.3f}" for x in coefficients),
        f"{linear.k:.3f}",
        f"{1e3 * linear.T:.2f}",
        f"{linear.xi:.3f}",
    ]


def filmed(motion: CommandSettings, duration_s: float) -> Recording:
    """Simulate, film, track: what `servosight simulate` and `servosight track` do."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "recording"
        produce(scenario(motion, duration_s, video=True), folder)
        return read(folder)


def fitted(recording: Recording) -> Solution:
    """The linear model."""
    return identify([recording], [], catalogue=catalogue(), method="gradient")


def through_the_video() -> str:
    """k, T and xi through the video, and eq. 2 by Tustin's rule."""
    sine = filmed(SINE, 4.0)
    recordings = {
        "1 Hz sine, from its start": sine,
        "1 Hz sine, steady (from 1 s on)": settled(sine),
        "servosight's standard": filmed(RICH, 6.0),
    }
    rows = []
    for name, recording in recordings.items():
        found = fitted(recording)
        values = found.actuator.parameters
        cells = [
            f"{scale * values[key].value:.4g} ± "
            + ("?" if values[key].sigma is None else f"{scale * values[key].sigma:.2g}")
            for key, scale in (("k", 1.0), ("T", 1e3), ("xi", 1.0))
        ]
        linear = Linear(*(values[key].value for key in ("k", "T", "xi")))
        one = to_difference(linear, 0.01)
        back = to_linear(one)
        cells += [f"{x:.3f}" for x in (one.a1, one.a2, one.b0, one.b1, one.b2)]
        cells.append(f"{max(abs(back.T / linear.T - 1), abs(back.xi / linear.xi - 1)):.0e}")
        rows.append([name, f"{found.rmse_deg:.2g}", *cells])
    truth = to_difference(Linear(TRUE.k, TRUE.T, TRUE.xi), 0.01)
    exact = [f"{x:.3f}" for x in (truth.a1, truth.a2, truth.b0, truth.b1, truth.b2)]
    rows.append(["truth", "", f"{TRUE.k:g}", f"{1e3 * TRUE.T:g}", f"{TRUE.xi:g}", *exact, ""])
    head = ["", "rmse [deg]", "k", "T [ms]", "xi", "a1", "a2", "b0", "b1", "b2", "there and back"]
    return table(head, rows)


def what_a_sine_determines() -> str:
    """T fixed at values from an eighth to two and a half times the truth, all else refitted."""
    held = {
        name: with_T_fixed(settled(made(motion, 10.0, 0.0, 0)), TIMES_S)
        for name, motion in MOTIONS.items()
    }
    sine, rich = held.values()

    def paint(figure: Figure) -> None:
        axes = figure.subplots()
        for (name, lines), colour in zip(held.items(), (BEFORE, AFTER), strict=True):
            axes.plot(
                [1e3 * one.T for one in lines],
                [max(one.rms_deg, 1e-6) for one in lines],
                color=colour,
                marker="o",
                markersize=3.5,
                label=name,
            )
        axes.axhline(TEMPLATE_DEG, color=FAINT, linestyle="--")
        axes.text(20.0, 1.2 * TEMPLATE_DEG, "noise of template matching", ha="right", fontsize=8)
        axes.set_yscale("log")
        axes.set_xlabel("T fixed at [ms]")
        axes.set_ylabel("misfit without noise [deg]")
        axes.legend(loc="center right")

    rows = [
        [
            f"{1e3 * one.T:g}",
            f"{one.xi:.3f}",
            f"{one.k:.4f}",
            f"{one.rms_deg:.2g}",
            f"{other.rms_deg:.2g}",
        ]
        for one, other in zip(sine, rich, strict=True)
    ]
    head = ["T fixed at [ms]", "then xi", "then k", "misfit, sine [deg]", "misfit, standard [deg]"]
    alt = "Misfit over the time constant, for a sine and for the standard excitation"
    return picture("sine", (6.5, 3.6), alt, paint) + "\n\n" + table(head, rows)


def scatter() -> str:
    """k, T and xi of 20 noises of 0.02 deg, steady motion alone."""
    rows = []
    for name, motion in MOTIONS.items():
        found = []
        for seed in SEEDS:
            values = fitted(settled(made(motion, 10.0, TEMPLATE_DEG, seed))).actuator.parameters
            found.append([values[key].value for key in ("k", "T", "xi")])
        k, T, xi = np.array(found).T
        lag = 2e3 * T * xi
        rows.append(
            [
                name,
                *(f"{x.min():.4g} to {x.max():.4g}" for x in (k, 1e3 * T, xi)),
                f"{lag.min():.4g} to {lag.max():.4g}",
            ]
        )
    return table(["", "k", "T [ms]", "xi", "2 xi T [ms]"], rows)
