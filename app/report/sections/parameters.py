"""The model's numbers with their uncertainty, and what each means."""

from __future__ import annotations

from collections.abc import Iterator

from servosight.app.report.section import Section
from servosight.app.report.story import Story, catalogue_of
from servosight.diagnose import Diagnosis, Step
from servosight.models.core import CORE, OWN, Estimate
from servosight.models.effects import Effect


def section(story: Story) -> Section | None:
    """None for a comparison, whose model is given."""
    result = story.result
    if not isinstance(result, Diagnosis):
        return None
    last = result.ladder[-1]
    fitted = [recording.name for recording in last.trial.fit.problem.recordings]
    return Section(
        "parameters",
        "The model in numbers",
        {
            "core": {parameter.name: last.parameters[parameter.name] for parameter in CORE},
            "rows": [*_rows(last, catalogue_of(result)), *_biases(last, fitted)],
            "warnings": last.warnings,
        },
    )


def _rows(step: Step, catalogue: dict[str, Effect]) -> Iterator[tuple[str, Estimate, str]]:
    """Name, estimate and meaning of what all recordings share."""
    meanings = {parameter.name: parameter.meaning for parameter in CORE}
    for name in step.trial.effects:
        meanings |= {f"{name}.{q.name}": q.meaning for q in catalogue[name].parameters}
    for name, estimate in step.parameters.items():
        if name in meanings:
            yield name, estimate, meanings[name]


def _biases(step: Step, fitted: list[str]) -> Iterator[tuple[str, Estimate, str]]:
    for name, bias in zip(fitted, step.biases, strict=True):
        where = f", {name}" if len(fitted) > 1 else ""
        yield "bias", bias, f"{OWN[0].meaning}{where}"
