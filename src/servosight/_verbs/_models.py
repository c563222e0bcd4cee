"""``ss.identify``, ``ss.predict``, ``ss.diagnose`` and ``ss.add``: models of recordings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, overload

from servosight._verbs._given import (
    actuator_of,
    catalogue_of,
    names_of,
)
from servosight._verbs._threads import one_algebra_thread
from servosight.models.base import is_fmu, silent

if TYPE_CHECKING:
    from servosight._verbs._given import Model, Source, Sources
    from servosight.diagnose import Diagnosis
    from servosight.identify.fit import Fit
    from servosight.identify.foreign import FmuFit
    from servosight.models.core import Array, StageProgress


@overload
def identify(
    recordings: Sources,
    effects: Sequence[str] = (),
    *,
    method: str = "combination",
    seed: int = 0,
    tolerance: float | None = None,
    fix: Mapping[str, float] | None = None,
    plugins: Sequence[Path | str] = (),
    model: None = None,
) -> Fit: ...
@overload
def identify(
    recordings: Sources,
    effects: Sequence[str] = (),
    *,
    tolerance: float | None = None,
    fix: Mapping[str, float] | None = None,
    plugins: Sequence[Path | str] = (),
    model: Path | str,
    parameters: Sequence[str] = (),
    trust: bool = False,
) -> FmuFit: ...
@one_algebra_thread
def identify(
    recordings: Sources,
    effects: Sequence[str] = (),
    *,
    method: str = "combination",
    seed: int = 0,
    tolerance: float | None = None,
    fix: Mapping[str, float] | None = None,
    plugins: Sequence[Path | str] = (),
    model: Path | str | None = None,
    parameters: Sequence[str] = (),
    trust: bool = False,
) -> Fit | FmuFit:
    """Fit k, T, xi, bias and the parameters of ``effects`` to recordings, jointly.

    ``method`` is combination (genetic operators and swarm), ga, pso or gradient; ``seed`` that of
    its random numbers. ``tolerance`` [deg] is what no model need reach (default 0.05 % of the moved
    range). ``fix`` holds parameters at known values, such as ``{"k": 1.0}``; their sigma is 0.
    ``plugins`` are files with effects of your own, which are run. With the path of an FMU as
    ``model`` its ``parameters`` (default: all tunable ones) are fitted instead, with ``effects``
    around it, to an ``FmuFit``: it runs native code, so it takes ``trust``. Raises InputError for a
    recording, an effect, a method, a seed, a tolerance or a parameter that is none.

    >>> import servosight as ss
    >>> fit = ss.identify(ss.simulate(seed=3), method="gradient")
    >>> sorted(fit.parameters)
    ['T', 'bias', 'k', 'xi']
    """
    from servosight.diagnose import with_detectable
    from servosight.identify.fit import identify, with_information
    from servosight.identify.foreign import identify_fmu
    from servosight.sources import read_all

    known, given, chosen = catalogue_of(plugins), read_all(recordings), names_of(effects)
    if model is not None:
        return identify_fmu(
            Path(model),
            given,
            names_of(parameters),
            chosen,
            catalogue=known,
            trust=trust,
            fix=fix,
            tolerance=tolerance,
        )
    fit = identify(
        given, chosen, catalogue=known, method=method, seed=seed, tolerance=tolerance, fix=fix
    )
    found = with_detectable(with_information(fit, given, known), given, known)
    return found.remember(given, known)


def predict(
    model: Model,
    on: Source,
    *,
    rate_hz: float | None = None,
    plugins: Sequence[Path | str] = (),
    trust: bool = False,
) -> Array:
    """Angle [deg] at the times of the recording ``on``, (samples,), from its command alone.

    ``model`` is a fit, a diagnosis, an actuator, or the path of a model card or of an FMU, which
    runs native code and so takes ``trust``. The run begins as the recording does. ``on`` may be the
    path of a command file, too (``time_s,command_deg`` and no angle): the run then begins at rest
    and lasts from the first row to the last, with an angle each ``1 / rate_hz``; without a rate at
    the rows where these are at most 10 ms apart, else at 100 Hz. Raises InputError for what is no
    model, recording or command, and for a rate with a recording.

    >>> import servosight as ss
    >>> recording = ss.simulate(seed=3)
    >>> ss.predict(ss.identify(recording, method="gradient"), recording).size
    2401
    """
    from servosight.identify.foreign import Interface, predict_fmu
    from servosight.models.plant import predict, predict_from_rest, to_the_end
    from servosight.sources import to_predict

    recording, from_rest = to_predict(on, rate_hz)
    if is_fmu(model):
        return predict_fmu(Interface(Path(model)), recording, from_rest=from_rest, trust=trust)
    known = catalogue_of(plugins)
    run = predict_from_rest if from_rest else predict
    return to_the_end(run(actuator_of(model, known), recording, known), recording)


# Long by its keywords, each of which is documented and passed on by name.
@one_algebra_thread
def diagnose(
    recordings: Sources,
    *,
    validate: Sources = (),
    test: Sources = (),
    auto: bool = True,
    tolerance: float | None = None,
    start: Model | None = None,
    with_effects: Sequence[str] = (),
    without_effects: Sequence[str] = (),
    fix: Mapping[str, float] | None = None,
    plugins: Sequence[Path | str] = (),
    progress: StageProgress | None = None,
    trust: bool = False,
) -> Diagnosis:
    """Find out which physical effects the linear model misses.

    The fit sees ``recordings``; which effects enter is decided on ``validate``; ``test`` is looked
    at once, for the report. Without them, blocks of one second are held out. With ``auto`` the best
    effect is added and fitted again until the error is at the floor or nothing helps; without, the
    candidates of the first step are ranked. ``tolerance`` [deg] is what no model need reach
    (default 0.05 % of the moved range). ``progress(word, done, total)`` is called as it goes.

    What is known before: ``start`` is a model (or its card) to start from, its effects in the first
    step and its values the initial guess; ``with_effects`` are in every model, ``without_effects``
    in none, and ``fix`` holds parameters, such as ``{"k": 1.0}``. InputError where these contradict
    one another. The path of an FMU as ``start`` puts it in the place of the linear model, with
    effects around it: it runs native code, so it takes ``trust``.

    >>> import servosight as ss
    >>> recording = ss.simulate(effect="backlash", set={"backlash.gap": 1.5}, seed=3)
    >>> why = ss.diagnose(recording)
    >>> why.effects
    ('backlash',)
    """
    from servosight.diagnose import PriorKnowledge, diagnose, diagnose_fmu
    from servosight.identify.foreign import Interface
    from servosight.sources import read_all

    known = catalogue_of(plugins)
    fitted, validating, testing = read_all(recordings), read_all(validate), read_all(test)
    if is_fmu(start):
        return diagnose_fmu(
            Interface(Path(start)),
            fitted,
            validating,
            testing,
            trust=trust,
            catalogue=known,
            with_effects=names_of(with_effects),
            without_effects=names_of(without_effects),
            fix=fix,
            auto=auto,
            tolerance=tolerance,
            progress=progress or silent,
        )
    prior = PriorKnowledge.of(
        known,
        start=None if start is None else actuator_of(start, known),
        with_effects=names_of(with_effects),
        without_effects=names_of(without_effects),
        fix=fix,
    )
    found = diagnose(
        fitted,
        validating,
        testing,
        catalogue=known,
        auto=auto,
        tolerance=tolerance,
        prior=prior,
        progress=progress or silent,
    )
    return found.remember([*fitted, *validating, *testing], known)


@one_algebra_thread
def add(
    model: Model, effect: str, recordings: Sources, *, plugins: Sequence[Path | str] = ()
) -> Fit:
    """The model with one more effect, all parameters fitted to the recordings jointly.

    Raises InputError where the model has that effect already, or no such effect exists.

    >>> import servosight as ss
    >>> recording = ss.simulate(effect="backlash", set={"backlash.gap": 1.5}, seed=3)
    >>> better = ss.add(ss.identify(recording, method="gradient"), "backlash", recording)
    >>> round(better.parameters["backlash.gap"].value, 1)
    1.5
    """
    from servosight.diagnose import add
    from servosight.sources import read_all

    known, given = catalogue_of(plugins), read_all(recordings)
    return add(actuator_of(model, known), effect, given, catalogue=known).remember(given, known)
