"""``ss.compare``: a model with recordings, or two of a kind with one another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Literal, cast, overload

from servosight._verbs._given import (
    actuator_of,
    catalogue_of,
    is_model,
    models_change,
    names_of,
)
from servosight._verbs._threads import one_algebra_thread
from servosight.models.base import is_fmu, silent

if TYPE_CHECKING:
    from servosight._verbs._given import Model, ModelValue, Recordings, Sources
    from servosight.diagnose import Comparison
    from servosight.diagnose.change import ServoChange
    from servosight.models.core import StageProgress


@overload
def compare(
    model: ModelValue, recordings: ModelValue, *, plugins: Sequence[Path | str] = ()
) -> ServoChange: ...
@overload
def compare(
    model: ModelValue,
    recordings: Recordings,
    *,
    tolerance: float | None = None,
    plugins: Sequence[Path | str] = (),
) -> Comparison: ...
@overload
def compare(
    model: Recordings,
    recordings: Sources,
    *,
    effects: Sequence[str] | None = None,
    fix: Mapping[str, float] | None = None,
    plugins: Sequence[Path | str] = (),
    progress: StageProgress | None = None,
) -> ServoChange: ...
@overload
def compare(
    model: Path | str, recordings: ModelValue, *, plugins: Sequence[Path | str] = ()
) -> ServoChange: ...
@overload
def compare(
    model: Path | str,
    recordings: Sources,
    *,
    tolerance: float | None = None,
    plugins: Sequence[Path | str] = (),
    trust: Literal[True],
) -> Comparison: ...
@overload
def compare(
    model: Model,
    recordings: Path | str | Recordings,
    *,
    tolerance: float | None = None,
    effects: Sequence[str] | None = None,
    fix: Mapping[str, float] | None = None,
    plugins: Sequence[Path | str] = (),
    progress: StageProgress | None = None,
    trust: bool = False,
) -> Comparison | ServoChange: ...
# Long by its keywords, each of which is documented and passed on by name.
@one_algebra_thread
def compare(
    model: Model | Sources,
    recordings: Model | Sources,
    *,
    tolerance: float | None = None,
    effects: Sequence[str] | None = None,
    fix: Mapping[str, float] | None = None,
    plugins: Sequence[Path | str] = (),
    progress: StageProgress | None = None,
    trust: bool = False,
) -> Comparison | ServoChange:
    """A model on recordings: where it fails. Two models, or two sets of recordings: what differs.

    ``model`` is a fit, a diagnosis (its last step), an actuator, or the path of a model card. On
    ``recordings`` its physical parameters stay as they are; bias and initial state are found on
    each. The path of an FMU (``.fmu``) is a model, too: it runs native code, so it takes ``trust``.

    With a second model in their place, or with recordings in both places, the result is a
    ``ServoChange``: which parameters differ, how surely, and what that can mean. To recordings one
    model is fitted, with ``effects`` or, without them, those that a diagnosis of either finds, and
    with the parameters of ``fix`` held; a folder of recordings is a set. A type checker cannot see
    which of the two a path is: narrow the result by ``isinstance`` there. Raises InputError for
    anything else.

    >>> import servosight as ss
    >>> recording = ss.simulate(effect="backlash", set={"backlash.gap": 1.5}, seed=3)
    >>> fit = ss.identify(recording, method="gradient")
    >>> ss.compare(fit, recording).explained
    False
    >>> ss.compare(fit, fit).changed
    ()
    """
    from servosight.diagnose import compare, compare_fmu
    from servosight.diagnose.change import change_in_recordings, refuse_fitting
    from servosight.identify.foreign import Interface
    from servosight.models.effects import select
    from servosight.sources import read_all, recordings_in

    known = catalogue_of(plugins)
    if is_model(recordings) and not is_model(model):
        model, recordings = recordings, model
    if not is_model(model):
        both = cast("tuple[Sources, Sources]", (model, recordings))
        first, second = (read_all(recordings_in(one)) for one in both)
        chosen = None if effects is None else select(known, names_of(effects))
        return change_in_recordings(
            first,
            second,
            catalogue=known,
            effects=chosen,
            fix=fix,
            progress=progress or silent,
        )
    refuse_fitting(effects, fix)
    if is_model(recordings):
        return models_change(model, recordings, known)
    given = read_all(cast("Sources", recordings))
    if is_fmu(model):
        return compare_fmu(Interface(Path(model)), given, trust=trust, tolerance=tolerance)
    found = compare(actuator_of(model, known), given, catalogue=known, tolerance=tolerance)
    return found.remember(given, known)
