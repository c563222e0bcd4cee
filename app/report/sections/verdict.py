"""What was missing, in one sentence, and how far the error fell."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from servosight.app.report.section import Section
from servosight.app.report.story import LEAST_DEG, Story, catalogue_of, listed, tolerance_deg
from servosight.diagnose import Comparison, Diagnosis
from servosight.diagnose.discrepancy import Law
from servosight.diagnose.residuals import findings, lead
from servosight.diagnose.selection import MIN_GAIN, Judged
from servosight.models.core import degrees, percent, times

MOST = 3
"""Findings on what remains that the verdict shows."""


def section(story: Story) -> Section:
    """The verdict of a diagnosis or of a comparison."""
    result = story.result
    if isinstance(result, Diagnosis):
        headline, sentence = _words(result)
        values = {
            "tiles": _tiles(story, result),
            "effects": _effects(result),
            "heading": "What that means" if result.verdict == "explained" else "What was added",
            "doubt": _doubt(result),
            "next": result.next_experiment,
            "counted": "data that the model was not fitted to",
        }
    else:
        headline, sentence = _compared(result)
        values = {
            "tiles": [
                _tile("model’s error", result.rmse_deg, "before"),
                *_limits(story),
                _fit_tile(story),
            ],
            "effects": [],
            "heading": None,
            "doubt": None,
            "next": None,
            "counted": "all samples",
        }
    return Section("verdict", headline, {"sentence": sentence, "floor": story.floor_deg, **values})


def _words(result: Diagnosis) -> tuple[str, str]:
    """Headline and one sentence."""
    first = result.ladder[0].trial.held_out_rmse_deg
    last = result.ladder[-1].trial.held_out_rmse_deg
    named = listed(result.effects)
    if result.verdict == "no_effect_missing":
        return (
            "No effect is missing",
            f"The linear model predicts the surface to {degrees(first)}, {_reached(result, first)}",
        )
    if result.verdict == "explained":
        return (
            f"What was missing: {named}",
            f"The linear model of this servo lacks {named}. With {named} in the model, its error "
            f"falls from {degrees(first)} to {degrees(last)}, {_reached(result, last)}",
        )
    above = f"{times(last / result.floor_deg)} times the floor of {degrees(result.floor_deg)}"
    if result.law is not None:
        return ("Not explained by any known effect, but by a law", _lawful(result, result.law))
    if result.effects:
        return (
            "Not fully explained",
            f"Adding {named} lowers the linear model’s error from {degrees(first)} to "
            f"{degrees(last)}, still {above}: something remains that no known effect accounts for.",
        )
    best = result.candidates[0] if result.candidates else None
    if best is not None and best.held_out_rmse_deg <= (1.0 - MIN_GAIN) * first:
        return (
            "The linear model misses something",
            f"The error of the linear model is {degrees(first)}, {above}. Of the known effects, "
            f"{listed([best.effect])} alone would help most and lower it to "
            f"{degrees(best.held_out_rmse_deg)}.",
        )
    return (
        "The linear model misses something",
        f"The error of the linear model is {degrees(first)}, {above}, and no single known effect "
        f"accounts for it.",
    )


def _lawful(result: Diagnosis, law: Law) -> str:
    """What was found for what no effect of the catalogue accounts for."""
    before, after = law.before.held_out_rmse_deg, law.after.held_out_rmse_deg
    named = f" with {listed(law.before.effects)}" if law.before.effects else ""
    terms = ", and ".join(form.words for form in law.terms)
    share = f"{100.0 * min(law.closed, 1.0):.0f} %"
    return (
        f"Something remains that no known effect accounts for: a torque that goes {terms}. With "
        f"this law the error of the model{named} falls from {degrees(before)} to {degrees(after)}, "
        f"which closes {share} of the gap to the floor of {degrees(result.floor_deg)}."
    )


def _reached(result: Diagnosis | Comparison, error_deg: float) -> str:
    """How an error that is at the floor compares with noise and tolerance."""
    noise, floor = result.noise_deg, result.floor_deg
    tolerance = tolerance_deg(noise, floor)
    if tolerance > noise and error_deg < 0.5 * floor:
        return (
            f"far below the tolerance of {degrees(tolerance)} at which the search ends; the noise "
            f"of the measurement is {degrees(noise)}."
        )
    if tolerance > noise:
        return (
            f"within the tolerance of {degrees(tolerance)}; the noise of the measurement is "
            f"{degrees(noise)}."
        )
    return f"no more than the noise of the measurement, {degrees(noise)}, accounts for."


def _compared(result: Comparison) -> tuple[str, str]:
    error, floor = degrees(result.rmse_deg), degrees(result.floor_deg)
    if result.explained:
        return (
            "The model holds",
            f"On these recordings the error of the model is {error}, "
            f"{_reached(result, result.rmse_deg)}",
        )
    return (
        "The model misses something",
        f"On these recordings the error of the model is {error}, "
        f"{times(result.rmse_deg / result.floor_deg)} times the floor of {floor}.",
    )


def _tiles(story: Story, result: Diagnosis) -> list[dict[str, str]]:
    first = result.ladder[0].trial.held_out_rmse_deg
    last = result.ladder[-1].trial.held_out_rmse_deg
    tiles = [_tile("error of the linear model", first, "before")]
    if result.effects:
        tiles.append(_tile(f"error with {listed(result.effects)}", last, "after"))
    if result.law is not None:
        last = result.law.after.held_out_rmse_deg
        tiles.append(_tile("error with the law that was found", last, "after"))
    if len(tiles) > 1:
        ratio = times(first / max(last, LEAST_DEG))
        tiles.append({"label": "times less", "value": ratio, "kind": "plain"})
    return [*tiles, *_limits(story), _fit_tile(story)]


def _limits(story: Story) -> list[dict[str, str]]:
    """Noise and tolerance: two numbers, whose root of squares is the floor."""
    allowed = tolerance_deg(story.noise_deg, story.floor_deg)
    return [
        _tile("noise of the measurement", story.noise_deg, "floor"),
        _tile("tolerance", allowed, "floor"),
    ]


def _fit_tile(story: Story) -> dict[str, str]:
    last = story.models[-1]
    return {
        "label": f"fit (NRMSE), {last.name}",
        "value": f"{percent(fit_percent(last.judged))} %",
        "kind": "plain",
    }


def fit_percent(judged: Sequence[Judged]) -> float:
    """100 (1 - |y - model| / |y - mean y|) over held-out samples; all, where none are held out."""
    held = any(not one.training.all() for one in judged)
    error = away = 0.0
    for one in judged:
        scored = ~one.training if held else one.training
        if scored.any():
            angle = one.recording.angle_deg[scored]
            error += float(np.sum(one.error_deg[scored] ** 2))
            away += float(np.sum((angle - angle.mean()) ** 2))
    return 100.0 * (1.0 - float(np.sqrt(error / max(away, LEAST_DEG**2))))


def _tile(label: str, value: float, kind: str) -> dict[str, str]:
    return {"label": label, "value": degrees(value), "kind": kind}


def _effects(result: Diagnosis) -> list[dict[str, Any]]:
    """Each effect that was missing: its words and its fitted parameters."""
    catalogue = catalogue_of(result)
    found = result.ladder[-1].parameters
    return [
        {
            "effect": catalogue[name],
            "parameters": [
                (parameter, found[f"{name}.{parameter.name}"])
                for parameter in catalogue[name].parameters
            ],
        }
        for name in result.effects
    ]


def _doubt(result: Diagnosis) -> str | None:
    """Models that this recording cannot rule out, or what the error that remains looks like."""
    if result.effects and result.alternatives:
        others = "; ".join(_model(result.effects, other) for other in result.alternatives)
        return (
            f"These recordings cannot tell {listed(result.effects)} from {others}: do not "
            f"rely on the name until the next experiment has decided."
        )
    if result.effects and result.verdict == "unexplained":
        judged = result.ladder[-1].trial.judged
        found = findings(judged, result.floor_deg, result.noise_deg)
        words = [lead(judged, found, result.floor_deg), *(one.sentence for one in found[:MOST])]
        return f"What the remaining error shows: {' '.join(words)}"
    return None


def _model(chosen: Sequence[str], other: Sequence[str]) -> str:
    """Another model, by what it has in place of the chosen one's."""
    return listed([name for name in other if name not in chosen] or other)
