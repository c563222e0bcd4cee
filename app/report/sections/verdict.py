"""What was missing, in one sentence, and how far the error fell."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from servosight.app.report.section import Section
from servosight.app.report.story import LEAST_DEG, Story, catalogue_of, listed
from servosight.diagnose.compare import Comparison
from servosight.diagnose.diagnose import Diagnosis
from servosight.diagnose.evidence import MIN_GAIN
from servosight.diagnose.findings import findings, lead
from servosight.models.rounding import degrees, times

MOST = 3
"""Findings on what remains that the verdict shows."""


def section(story: Story) -> Section:
    """The verdict of a diagnosis or of a comparison."""
    result = story.result
    if isinstance(result, Diagnosis):
        headline, sentence = _words(result)
        values = {
            "tiles": _tiles(result),
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
                _tile("floor of the measurement", result.floor_deg, "floor"),
            ],
            "effects": [],
            "heading": None,
            "doubt": None,
            "next": None,
            "counted": "all samples",
        }
    return Section("verdict", headline, {"sentence": sentence, **values})


def _words(result: Diagnosis) -> tuple[str, str]:
    """Headline and one sentence."""
    first = result.ladder[0].trial.held_out_rmse_deg
    last = result.ladder[-1].trial.held_out_rmse_deg
    named = listed(result.effects)
    if result.verdict == "no_effect_missing":
        return (
            "Nothing is missing",
            f"The linear model already predicts the surface to {degrees(first)}, which is as "
            f"exact as the measurement allows.",
        )
    if result.verdict == "explained":
        return (
            f"What was missing: {named}",
            f"The linear model of this servo lacks {named}; once the model knows of it, its error "
            f"falls from {degrees(first)} to {degrees(last)}, as exact as the measurement allows.",
        )
    if result.effects:
        return (
            "Not explained yet",
            f"Adding {named} lowers the linear model’s error from {degrees(first)} to "
            f"{degrees(last)}, still {times(last / result.floor_deg)} times what the measurement "
            f"allows: something remains that no known effect accounts for.",
        )
    best = result.candidates[0] if result.candidates else None
    if best is not None and best.held_out_rmse_deg <= (1.0 - MIN_GAIN) * first:
        return (
            "The linear model misses something",
            f"The linear model is {degrees(first)} off; of the known effects, "
            f"{listed([best.effect])} alone would help most and bring that to "
            f"{degrees(best.held_out_rmse_deg)}.",
        )
    return (
        "The linear model misses something",
        f"The linear model is {degrees(first)} off, {times(first / result.floor_deg)} times what "
        f"the measurement allows, and no single known effect accounts for it.",
    )


def _compared(result: Comparison) -> tuple[str, str]:
    ratio = result.rmse_deg / result.floor_deg
    if result.explained:
        return (
            "The model holds",
            f"On these recordings the model is {degrees(result.rmse_deg)} off, as exact as the "
            f"measurement allows.",
        )
    return (
        "The model misses something",
        f"On these recordings the model is {degrees(result.rmse_deg)} off, {times(ratio)} times "
        f"what the measurement allows.",
    )


def _tiles(result: Diagnosis) -> list[dict[str, str]]:
    first = result.ladder[0].trial.held_out_rmse_deg
    last = result.ladder[-1].trial.held_out_rmse_deg
    tiles = [_tile("error of the linear model", first, "before")]
    if result.effects:
        tiles.append(_tile(f"error with {listed(result.effects)}", last, "after"))
        tiles.append(
            {"label": "times less", "value": times(first / max(last, LEAST_DEG)), "kind": "plain"}
        )
    return [*tiles, _tile("floor of the measurement", result.floor_deg, "floor")]


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
            f"These recordings cannot tell {listed(result.effects)} from {others}: take the name "
            f"with care until the next experiment has decided."
        )
    if result.effects and result.verdict == "unexplained":
        judged = result.ladder[-1].trial.judged
        found = findings(judged, result.floor_deg, result.noise_deg)
        words = [lead(judged, found, result.floor_deg), *(one.sentence for one in found[:MOST])]
        return f"What remains looks like this. {' '.join(words)}"
    return None


def _model(chosen: Sequence[str], other: Sequence[str]) -> str:
    """Another model, by what it has in place of the chosen one's."""
    return listed([name for name in other if name not in chosen] or other)
