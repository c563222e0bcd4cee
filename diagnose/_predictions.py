"""The predictions of a diagnosis, simulated anew from its values and the recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from servosight.diagnose._result import Diagnosis, RecordingUse
from servosight.diagnose.discrepancy import law_effects
from servosight.diagnose.residuals import FIT, TEST, VALIDATION, Judged, Uses
from servosight.identify.fit import OwnValues, predicted_angle
from servosight.identify.problem import thinned
from servosight.models.core import Estimate, InputError, Recording, views
from servosight.models.effects import Effect
from servosight.models.effects import catalogue as built_in

Values = Mapping[str, Estimate | tuple[Estimate, ...]]


def predictions(
    diagnosis: Diagnosis,
    recordings: Sequence[Recording],
    step: int = -1,
    *,
    catalogue: Mapping[str, Effect] | None = None,
) -> tuple[Judged, ...]:
    """What a step of the ladder (default: the last) predicts for the diagnosed recordings.

    ``recordings`` are those of the diagnosis in its order: fitted, validation, test. Raises
    InputError where they are others.
    """
    found = diagnosis.ladder[step]
    effects = built_in() if catalogue is None else catalogue
    return _simulated(diagnosis, recordings, found.effects, found.parameters, found.own, effects)


def law_predictions(
    diagnosis: Diagnosis,
    recordings: Sequence[Recording],
    *,
    catalogue: Mapping[str, Effect] | None = None,
) -> tuple[Judged, ...]:
    """What the model with the law predicts; empty where no law was found."""
    law = diagnosis.law
    if law is None:
        return ()
    effects = {**(built_in() if catalogue is None else catalogue), **law_effects()}
    return _simulated(diagnosis, recordings, law.effects, law.parameters, law.own, effects)


def _simulated(
    diagnosis: Diagnosis,
    recordings: Sequence[Recording],
    effects: tuple[str, ...],
    parameters: Values,
    own: tuple[OwnValues, ...],
    catalogue: Mapping[str, Effect],
) -> tuple[Judged, ...]:
    given, _ = thinned(views(recordings))
    expected = [one.name for one in diagnosis.recordings]
    if [one.name for one in given] != expected:
        raise InputError(
            f"the recordings are {', '.join(one.name for one in given)}; expected those of the "
            f"diagnosis in their order: {', '.join(expected)}"
        )
    return tuple(
        _judged(recording, effects, parameters, values, use, catalogue)
        for recording, values, use in zip(given, own, diagnosis.recordings, strict=True)
    )


def _judged(
    recording: Recording,
    effects: tuple[str, ...],
    parameters: Values,
    values: OwnValues,
    use: RecordingUse,
    catalogue: Mapping[str, Effect],
) -> Judged:
    angle = predicted_angle(recording, effects, parameters, values, catalogue)
    return Judged(recording, angle, _uses(recording, use))


def _uses(recording: Recording, use: RecordingUse) -> Uses:
    """The uses of the samples, from the times in the result."""
    whole = {"validation": VALIDATION, "test": TEST}.get(use.role, FIT)
    uses = np.full(recording.time_s.size, whole, dtype=np.int8)
    for kind, stretches in ((VALIDATION, use.validation_s), (TEST, use.test_s)):
        for start, end in stretches:
            uses[(recording.time_s >= start) & (recording.time_s <= end)] = kind
    return uses
