"""What was missing, line by line, and how far the error fell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from servosight.app.report.section import Section
from servosight.app.report.story import LEAST_DEG, Story
from servosight.diagnose import (
    Comparison,
    Diagnosis,
    Verdict,
    alternative_words,
    named_model,
    phrased,
    predictions,
)
from servosight.diagnose.residuals import lead
from servosight.models.core import degrees, percent, times
from servosight.models.effects import Effect

MOST = 3
"""Findings on what remains that the verdict shows."""


def section(story: Story) -> Section:
    """The verdict of a diagnosis or of a comparison."""
    result = story.result
    if isinstance(result, Diagnosis):
        values = {
            "tiles": _tiles(result),
            "effects": _effects(result, story.catalogue),
            "heading": "What that means" if result.verdict == "explained" else "What was added",
            "doubt": _doubt(story, result),
            "next": result.next_experiment,
            "warnings": result.warnings,
            "counted": "test data, which neither fitted nor chose the model",
        }
    else:
        values = {
            "tiles": [
                _tile("model’s error", result.rmse_deg, "before"),
                *_levels(result),
                *_fit_tile(result.fit_percent, story.before.name),
            ],
            "effects": [],
            "heading": None,
            "doubt": None,
            "next": None,
            "warnings": (),
            "counted": "all samples",
        }
    shared = {"lines": result.summary.splitlines(), "floor": story.floor_deg}
    return Section("verdict", result.headline, {**shared, **values})


def _tiles(result: Diagnosis) -> list[dict[str, str]]:
    first = result.ladder[0].held_out_rmse_deg
    last = result.ladder[-1].held_out_rmse_deg
    named = named_model(result.ladder[0].effects, result.ladder[0].base)
    tiles = [_tile(f"error of the {named}", first, "before")]
    if result.ladder[-1].effects != result.ladder[0].effects:
        tiles.append(_tile(f"error with {phrased(result.ladder[-1].effects)}", last, "after"))
    if result.law is not None:
        last = result.law.held_out_after_deg
        tiles.append(_tile("error with the law that was found", last, "after"))
    if len(tiles) > 1:
        ratio = times(first / max(last, LEAST_DEG))
        tiles.append({"label": "times less", "value": ratio, "kind": "plain"})
    step = result.ladder[-1]
    fit = _fit_tile(step.fit_percent, named_model(step.effects, step.base))
    return [*tiles, *_levels(result), *fit]


def _fit_tile(fit_percent: float | None, name: str) -> list[dict[str, str]]:
    """None for a result that was saved without it."""
    if fit_percent is None:
        return []
    value = f"{percent(fit_percent)} %"
    return [{"label": f"fit (NRMSE), {name}", "value": value, "kind": "plain"}]


def _tile(label: str, value: float, kind: str) -> dict[str, str]:
    return {"label": label, "value": degrees(value), "kind": kind}


def _levels(result: Diagnosis | Comparison) -> list[dict[str, str]]:
    """Noise and tolerance, which make the floor."""
    return [
        _tile("noise of the measurement", result.noise_deg, "floor"),
        _tile("tolerance", result.tolerance_deg, "floor"),
    ]


def _effects(result: Diagnosis, catalogue: Mapping[str, Effect]) -> list[dict[str, Any]]:
    """Each effect that was missing: its words and its fitted parameters.

    Of a special case that alone is certain these are the first ones of the effect that has it.
    """
    last = result.ladder[-1]
    shown = []
    for name in result.effects:
        owner = catalogue[_owner(name, last.effects, catalogue)]
        pairs = zip(catalogue[name].parameters, owner.parameters, strict=False)
        values = [(one, last.parameters[f"{owner.id}.{its.name}"]) for one, its in pairs]
        shown.append({"effect": catalogue[name], "parameters": values})
    return shown


def _owner(name: str, effects: Sequence[str], catalogue: Mapping[str, Effect]) -> str:
    """The effect of a model that has the named one: itself, or what contains it."""
    if name in effects:
        return name
    return next(one for one in effects if name in catalogue[one].contains)


def _doubt(story: Story, result: Diagnosis) -> str | None:
    """Models that this recording cannot rule out, or what the last step's error looks like."""
    if result.effects and result.alternatives:
        return alternative_words(result.effects, result.alternatives)
    if result.effects and result.verdict is Verdict.UNEXPLAINED:
        step, found = result.ladder[-1], result.remaining
        # The story's last model is the law where one was found; the findings are the step's.
        judged = predictions(result, story.recordings, catalogue=story.catalogue)
        words = [lead(judged, found, story.floor_deg), *(one.sentence for one in found[:MOST])]
        name = named_model(step.effects, step.base)
        return f"What the error of the {name} shows: {' '.join(words)}"
    return None
