"""The model's numbers with their uncertainty, and what each means."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from servosight.app.report.section import Section
from servosight.app.report.story import Story
from servosight.diagnose import Diagnosis, LadderStep
from servosight.identify.uncertainty import Matrix
from servosight.models.core import CORE, OWN, Estimate
from servosight.models.effects import Effect

SYMBOLS = {"xi": "ξ"}
"""How a parameter is written in the transfer function, where that is not its name."""
STRONG = 0.95
"""Above this correlation the recording hardly distinguishes two parameters."""
MOSTLY = 0.5
"""A parameter with a larger share of its variance from errors that all samples share is named."""


def section(story: Story) -> Section | None:
    """None for a comparison, whose model is given."""
    result = story.result
    if not isinstance(result, Diagnosis):
        return None
    last = result.ladder[-1]
    names = [name for one in result.recordings for name in one.parts]
    return Section(
        "parameters",
        "The model in numbers",
        {
            "core": [(SYMBOLS.get(one.name, one.name), last.parameters[one.name]) for one in CORE],
            "rows": [*_rows(last, story.catalogue), *_biases(last, names)],
            "correlation": _correlation(last),
            "uncorrelated": _uncorrelated(last),
            "shared": [(n, share) for n, share in last.shared_error.items() if share > MOSTLY],
            "strong": STRONG,
            "warnings": last.warnings,
        },
    )


def _correlation(step: LadderStep) -> list[tuple[str, list[float | None]]]:
    """A row for each shared parameter that is determined; None where a pair's is not known.

    What all samples share, such as the offset of the clocks, would make each pair +-1.
    """
    found = _shown(step)
    if found is None:
        return []
    known = np.asarray(np.isfinite(found.values).any(axis=1))
    return [
        (name, [float(value) if np.isfinite(value) else None for value in row[known]])
        for name, row, shown in zip(found.names, found.values, known, strict=True)
        if shown
    ]


def _shown(step: LadderStep) -> Matrix | None:
    """By noise alone; results of earlier versions have only the whole."""
    return step.sampling_correlation or step.correlation


def _uncorrelated(step: LadderStep) -> bool:
    """True where a parameter has no correlation with any: it is held, or undetermined."""
    found = _shown(step)
    return found is not None and not bool(np.isfinite(found.values).any(axis=1).all())


def _rows(step: LadderStep, catalogue: Mapping[str, Effect]) -> Iterator[tuple[str, Estimate, str]]:
    """Name, estimate and meaning of what all recordings share."""
    meanings = {parameter.name: parameter.meaning for parameter in CORE}
    for name in step.effects:
        meanings |= {f"{name}.{q.name}": q.meaning for q in catalogue[name].parameters}
    for name, estimate in step.parameters.items():
        if name in meanings and isinstance(estimate, Estimate):
            yield name, estimate, meanings[name]


def _biases(step: LadderStep, names: list[str]) -> Iterator[tuple[str, Estimate, str]]:
    """One bias for each fitted recording, or part of one: they come first."""
    bias = step.parameters["bias"]
    biases = (bias,) if isinstance(bias, Estimate) else bias
    for name, one in zip(names, biases, strict=False):
        where = f", {name}" if len(biases) > 1 else ""
        yield "bias", one, f"{OWN[0].meaning}{where}"
