"""The parameters of an FMU, fitted by Levenberg and Marquardt's descent from its own values."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from servosight.identify.fit import floor_deg
from servosight.identify.foreign._descent import End, Search, descent
from servosight.identify.foreign._joint import EffectsAround, effects_around
from servosight.identify.foreign._own import trusted
from servosight.identify.foreign._result import FmuFit
from servosight.identify.foreign._runs import Interface
from servosight.identify.problem import joint_noise_deg, thinned, unused_disturbances, usable_views
from servosight.identify.uncertainty import (
    Matrix,
    by_recording,
    determined_inverse,
    misfit_share,
    sampling_covariance,
)
from servosight.models.core import (
    Array,
    Estimate,
    InputError,
    Recording,
    did_you_mean,
    either,
    fit_percent,
    one_or_more,
    rms,
)
from servosight.models.effects import Effect, select
from servosight.models.effects import catalogue as built_in
from servosight.models.fmu import FmuModel, FmuVariable, open_fmu

METHOD = "gradient"


# Long by its keywords, each of which is documented.
def identify_fmu(
    path: Path,
    recordings: Sequence[Recording],
    names: Sequence[str] = (),
    effects: Sequence[str] = (),
    *,
    catalogue: Mapping[str, Effect] | None = None,
    trust: bool = False,
    fix: Mapping[str, float] | None = None,
    command: str | None = None,
    angle: str | None = None,
    tolerance: float | None = None,
) -> FmuFit:
    """Fit the parameters ``names`` of an FMU (default: all tunable ones) to recordings, jointly.

    With ``effects`` around the FMU their parameters are fitted together with its own. The search is
    a local one, from the FMU's own values and the effects' guesses. ``fix`` holds parameters. Where
    the FMU has parameters named ``bias``, ``initial_angle`` and ``initial_speed``, each recording
    has its own. Raises InputError where ``trust`` is not given, for a name that is none, and for
    whatever keeps the FMU from running.
    """
    trusted(path, trust)
    began = time.perf_counter()
    whole, left_out = usable_views(one_or_more(recordings))
    scored, notes = thinned(whole)
    noise = joint_noise_deg(tuple(whole))
    floor = floor_deg(whole, noise, tolerance)
    known = built_in() if catalogue is None else catalogue
    chosen = select(known, effects)
    interface = Interface(path, command, angle)
    with _opened(interface, known, chosen, scored, trust) as model:
        held = dict(fix or {})
        search = Search(
            model=model,
            runs=tuple(model.run_of(one) for one in scored),
            shared=_chosen(model, names, held),
            held=held,
        )
        end = descent(search)
    covariance = _covariance(search, end, noise)
    estimates, unknown = _estimates(search, end.point, covariance)
    shared = tuple(one.name for one in search.shared)
    rmse_deg = rms(end.residuals)
    return FmuFit(
        model=str(path),
        parameters=estimates,
        covariance=Matrix(shared, covariance[: len(shared), : len(shared)]),
        rmse_deg=rmse_deg,
        noise_deg=noise,
        floor_deg=floor,
        samples=end.residuals.size,
        method=METHOD,
        seconds=time.perf_counter() - began,
        stopped=end.stopped,
        warnings=(*left_out, *unused_disturbances(whole), *notes, *unknown),
        fixed=tuple(held),
        recordings=tuple(one.name for one in whole),
        paths=tuple(one.path for one in whole),
        evaluations=end.evaluations,
        fit_percent=fit_percent(rmse_deg, [one.angle_deg for one in scored], floor),
    )


@contextmanager
def _opened(
    interface: Interface,
    catalogue: Mapping[str, Effect],
    effects: Sequence[str],
    recordings: Sequence[Recording],
    trust: bool,
) -> Iterator[FmuModel | EffectsAround]:
    """The FMU, alone or with effects around it."""
    if effects:
        with effects_around(interface, catalogue, effects, recordings, trust=trust) as model:
            yield model
        return
    with open_fmu(interface.path) as fmu:
        yield FmuModel.of(fmu, interface.command, interface.angle)


def _chosen(
    model: FmuModel | EffectsAround, names: Sequence[str], held: Mapping[str, float]
) -> tuple[FmuVariable, ...]:
    """The parameters to fit; InputError for a name that is none, or for none at all."""
    there = {one.name: one for one in model.parameters}
    for name in (*names, *held):
        if name not in there:
            raise InputError(
                f"{model.fmu.path}: has no parameter {name}{did_you_mean(name, there)}; expected "
                f"some of {', '.join(list(there)[:12]) or 'none'}"
            )
    wanted = names or [one.name for one in there.values() if one.variability == "tunable"]
    if isinstance(model, EffectsAround):
        wanted = [*wanted, *(one.name for one in model.variables)]
    chosen = tuple(there[name] for name in dict.fromkeys(wanted) if name not in held)
    if not chosen and not model.own:
        raise InputError(
            f"{model.fmu.path}: has no tunable parameter, expected one to fit; name others by "
            f"{either('parameters', '--parameters')}, or compare it instead"
        )
    return chosen


def _covariance(search: Search, end: End, noise_deg: float) -> Array:
    """That of what differs from sample to sample, NaN where undetermined or on a bound."""
    low, high, _ = search.bounds()
    free = (end.point > low) & (end.point < high)
    inverse = determined_inverse(end.jacobian, free)
    known = np.isfinite(np.diag(inverse))
    every = [np.ones(run.recording.time_s.size, dtype=np.bool_) for run in search.runs]
    found = np.full(inverse.shape, np.nan)
    found[np.ix_(known, known)] = sampling_covariance(
        *by_recording(every, end.jacobian[:, known], end.residuals),
        every,
        [run.recording.time_s for run in search.runs],
        inverse[np.ix_(known, known)],
        np.flatnonzero(known) < len(search.shared),
        misfit_share(float(np.mean(end.residuals**2)), noise_deg),
        int(free.sum()),
    )
    return found


def _estimates(
    search: Search, point: Array, covariance: Array
) -> tuple[dict[str, Estimate | tuple[Estimate, ...]], list[str]]:
    """Each parameter with its sigma, and a sentence for each that has none."""
    variance = np.diag(covariance)
    every = [*search.shared, *search.model.own * len(search.runs)]
    numbers = [
        Estimate(float(value), float(np.sqrt(v)) if np.isfinite(v) else None, one.unit)
        for one, value, v in zip(every, point, variance, strict=True)
    ]
    count, own = len(search.shared), len(search.model.own)
    found: dict[str, Estimate | tuple[Estimate, ...]] = {
        one.name: number for one, number in zip(search.shared, numbers, strict=False)
    }
    for i, one in enumerate(search.model.own):
        each = tuple(numbers[count + i :: own]) if own else ()
        found[one.name] = each[0] if len(each) == 1 else each
    found |= {
        name: Estimate(float(value), 0.0, _unit(search, name))
        for name, value in search.held.items()
    }
    low, high, _ = search.bounds()
    notes = []
    for one, value, v, a, b in zip(every, point, variance, low, high, strict=True):
        if value in (a, b):
            notes.append(f"{one.name} rests on a bound of its range, so it has no sigma")
        elif not np.isfinite(v):
            notes.append(f"these recordings do not determine {one.name}, so it has no sigma")
    return found, list(dict.fromkeys(notes))


def _unit(search: Search, name: str) -> str:
    return next(one.unit for one in search.model.parameters if one.name == name)
