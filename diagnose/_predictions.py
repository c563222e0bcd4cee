"""The predictions of a diagnosis, simulated anew from its values and the recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from servosight.diagnose.discrepancy import law_effects
from servosight.diagnose.residuals import Judged, Uses
from servosight.diagnose.result import Diagnosis
from servosight.diagnose.selection import cut
from servosight.identify.fit import OwnValues, predicted_angle
from servosight.identify.foreign import is_around_fmu
from servosight.identify.problem import thinned, usable_views
from servosight.models.core import Estimate, InputError, Recording
from servosight.models.effects import Effect
from servosight.models.effects import catalogue as built_in

_ParameterValues = Mapping[str, Estimate | tuple[Estimate, ...]]


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
    parameters: _ParameterValues,
    own: tuple[OwnValues, ...],
    catalogue: Mapping[str, Effect],
) -> tuple[Judged, ...]:
    if diagnosis.fmu is not None and not is_around_fmu(catalogue):
        raise InputError(
            f"{diagnosis.fmu}: the predictions of this diagnosis are this FMU's, expected to run "
            f"it; use servosight diagnose --from {diagnosis.fmu} --trust --report REPORT.html"
        )
    given, _ = usable_views(recordings)
    expected = [one.name for one in diagnosis.recordings]
    if [one.name for one in given] != expected:
        raise InputError(
            f"the recordings are {', '.join(one.name for one in given)}; expected those of the "
            f"diagnosis in their order: {', '.join(expected)}"
        )
    whole = zip(given, diagnosis.recordings, strict=True)
    scored, _ = thinned(
        [use.seen(part) for one, use in whole for part in cut(one, use.stretches_s)]
    )
    uses = [use for use in diagnosis.recordings for _ in use.parts]
    return tuple(
        _judged(recording, effects, parameters, values, use.uses(recording), catalogue)
        for recording, values, use in zip(scored, own, uses, strict=True)
    )


def _judged(
    recording: Recording,
    effects: tuple[str, ...],
    parameters: _ParameterValues,
    values: OwnValues,
    uses: Uses,
    catalogue: Mapping[str, Effect],
) -> Judged:
    angle = predicted_angle(recording, effects, parameters, values, catalogue)
    return Judged(recording, angle, uses)
