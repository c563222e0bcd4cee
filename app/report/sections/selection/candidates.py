"""What could be missing: every effect tried alone, ranked by its evidence."""

from __future__ import annotations

from collections.abc import Sequence

from servosight.app.report.section import Section
from servosight.app.report.story import Story
from servosight.diagnose import Candidate, Diagnosis, alternative_words, listed, named_model
from servosight.diagnose.selection import SelectionPolicy

LEAST_EVIDENCE = SelectionPolicy().min_evidence
FEWEST_SHOWN = 4
"""Number of candidates that are shown even where they gain nothing."""


def section(story: Story) -> Section | None:
    """None for a comparison, which tries nothing."""
    result = story.result
    if not isinstance(result, Diagnosis) or not result.candidates:
        return None
    linear = result.ladder[0].held_out_rmse_deg
    largest = max([1e-300, linear, *(one.held_out_rmse_deg for one in result.candidates)])
    strongest = max([1e-9, *(one.evidence for one in result.candidates)])
    catalogue = story.catalogue
    shown = [
        one
        for place, one in enumerate(result.candidates)
        if place < FEWEST_SHOWN or one.evidence > LEAST_EVIDENCE or one.effect in result.effects
    ]
    return Section(
        "candidates",
        "What could be missing",
        {
            "base": named_model(result.ladder[0].effects, result.ladder[0].base),
            "linear_deg": linear,
            "linear_share": linear / largest,
            "floor_deg": story.floor_deg,
            "floor_share": min(story.floor_deg / largest, 1.0),
            "rows": [
                {
                    "candidate": one,
                    "place": catalogue[one.effect].place.value,
                    "chosen": one.effect in result.effects,
                    "error_share": one.held_out_rmse_deg / largest,
                    "evidence_share": max(one.evidence, 0.0) / strongest,
                }
                for one in shown
            ],
            "left_out": listed([one.effect for one in result.candidates if one not in shown]),
            "alternatives": _alternatives(result),
            "groups": [listed(group) for group in groups(result.candidates)],
            "unseen": listed([one.effect for one in result.detectable if one.value is None]),
            "sizes": [one.sentence for one in result.detectable if one.value is not None],
            "any_helps": strongest > LEAST_EVIDENCE,
        },
    )


def _alternatives(result: Diagnosis) -> str | None:
    """Models that predict the same as the answer; where nothing was added, as the best effect."""
    if not result.alternatives:
        return None
    return alternative_words(result.effects or (result.candidates[0].effect,), result.alternatives)


def groups(candidates: Sequence[Candidate]) -> list[tuple[str, ...]]:
    """Sets of effects that cannot be distinguished, each once, in the order of the ranking."""
    found = [
        tuple(other.effect for other in candidates if other.effect in {one.effect, *names})
        for one in candidates
        if (names := one.confounded_with)
    ]
    return list(dict.fromkeys(found))
