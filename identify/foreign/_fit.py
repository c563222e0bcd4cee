"""The parameters of an FMU, fitted by Levenberg and Marquardt's descent from its own values."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from servosight.identify.fit import floor_deg
from servosight.identify.foreign._joint import EffectsAround, effects_around
from servosight.identify.foreign._own import bounds_of, first_guess, predicted, trusted
from servosight.identify.foreign._result import FmuFit
from servosight.identify.foreign._runs import Interface
from servosight.identify.problem import joint_noise_deg, thinned, unused_disturbances, usable_views
from servosight.identify.search import LevenbergMarquardt, drive
from servosight.identify.uncertainty import (
    Matrix,
    by_recording,
    determined_inverse,
    weighted_normal,
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
)
from servosight.models.effects import Effect, select
from servosight.models.effects import catalogue as built_in
from servosight.models.fmu import FmuLimits, FmuModel, FmuRun, FmuVariable, open_fmu

BUDGET = 600
"""Runs of the FMU on all recordings."""
METHOD = "gradient"
_STARTS = 3
"""How many of the effects' guesses are followed down."""
_FAILED_DEG = 1e6
"""The residual where a run fails: that point is not taken."""


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
    limits: FmuLimits | None = None,
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
    interface = Interface(path, command, angle, limits)
    with _opened(interface, known, chosen, scored, trust) as model:
        held = dict(fix or {})
        search = _Search(
            model=model,
            runs=tuple(model.run_of(one) for one in scored),
            shared=_chosen(model, names, held),
            held=held,
        )
        end = _descent(search)
    covariance = _covariance(search, end)
    estimates, unknown = _estimates(search, end.point, covariance)
    shared = tuple(one.name for one in search.shared)
    rmse_deg = float(np.sqrt(np.mean(end.residuals**2)))
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
        fit_percent=fit_percent(rmse_deg, [one.angle_deg for one in scored]),
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
    with open_fmu(interface.path, limits=interface.limits) as fmu:
        yield FmuModel.of(fmu, interface.command, interface.angle)


@dataclass(frozen=True, kw_only=True)
class _Search:
    """The shared parameters, then the own ones of each recording, as one point."""

    model: FmuModel | EffectsAround
    runs: tuple[FmuRun, ...]
    shared: tuple[FmuVariable, ...]
    held: Mapping[str, float]

    def starts(self) -> Array:
        """The FMU's own values, and what the recordings say of their own: (starts, coordinates).

        With effects around it, the best of their guesses.
        """
        first = [one.start or 0.0 for one in self.shared]
        own = [first_guess(run.recording, self.model) for run in self.runs]
        start = np.concatenate([first, *own])
        if not isinstance(self.model, EffectsAround):
            return start[None, :]
        points = []
        for guess in self.model.guesses([run.recording for run in self.runs]):
            guessed = [guess.get(one.name, one.start or 0.0) for one in self.shared]
            points.append(np.concatenate([guessed, *own]))
        low, high, _ = self.bounds()
        table = np.clip(points, low, high)
        costs = np.sum(self.residuals(table) ** 2, axis=1)
        return np.asarray(table[np.argsort(costs, kind="stable")[:_STARTS]])

    def bounds(self) -> tuple[Array, Array, Array]:
        """Low, high and size of a change that matters, (coordinates,) each."""
        return bounds_of([*self.shared, *self.model.own * len(self.runs)])

    def check(self, start: Array) -> None:
        """Raise InputError where the FMU does not run at the start."""
        for run, (names, rows) in zip(self.runs, self._rows(start[None, :]), strict=True):
            _, errors = predicted(self.model, run, names, rows)
            if errors[0]:
                raise InputError(
                    f"{self.model.fmu.path}: does not run on {run.recording.name} ({errors[0]}), "
                    f"expected an FMU that does; try it in the tool it is of"
                )

    def residuals(self, points: Array) -> Array:
        """Predicted minus measured [deg], (points, samples of all recordings)."""
        parts = []
        for run, (names, rows) in zip(self.runs, self._rows(points), strict=True):
            angles, _ = predicted(self.model, run, names, rows)
            parts.append(angles - run.recording.angle_deg)
        return np.nan_to_num(np.hstack(parts), nan=_FAILED_DEG)

    def _rows(self, points: Array) -> list[tuple[list[str], Array]]:
        """Names and rows of parameters of each recording."""
        shared, own = len(self.shared), len(self.model.own)
        names = [one.name for one in (*self.shared, *self.model.own)] + list(self.held)
        held = np.tile(list(self.held.values()), (len(points), 1))
        found = []
        for i in range(len(self.runs)):
            begin = shared + i * own
            rows = np.hstack([points[:, :shared], points[:, begin : begin + own], held])
            found.append((names, rows))
        return found


@dataclass(frozen=True, kw_only=True)
class _End:
    """Where the search ended: (coordinates,), (samples,) [deg] and (samples, coordinates)."""

    point: Array
    residuals: Array
    jacobian: Array
    stopped: str
    evaluations: int


def _descent(search: _Search) -> _End:
    """From the FMU's own values down; InputError where it does not run there."""
    starts = search.starts()
    search.check(starts[0])
    ends = [
        drive(LevenbergMarquardt(start, *search.bounds()), search.residuals, BUDGET)
        for start in starts
    ]
    outcome = min(ends, key=lambda end: float(end.cost))
    final = LevenbergMarquardt(outcome.point, *search.bounds())
    points = final.ask()
    residuals = search.residuals(points)
    final.tell(points, residuals)
    assert final.jacobian is not None
    return _End(
        point=outcome.point,
        residuals=residuals[0],
        jacobian=final.jacobian,
        stopped=str(outcome.stopped),
        evaluations=sum(end.evaluations for end in ends),
    )


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


def _covariance(search: _Search, end: _End) -> Array:
    """The sandwich with autocorrelated residuals, NaN where undetermined or on a bound."""
    low, high, _ = search.bounds()
    free = (end.point > low) & (end.point < high)
    inverse = determined_inverse(end.jacobian, free)
    known = np.isfinite(np.diag(inverse))
    every = [np.ones(run.recording.time_s.size, dtype=np.bool_) for run in search.runs]
    parts = by_recording(every, end.jacobian[:, known], end.residuals)
    meat = sum(
        (weighted_normal(*one) for one in zip(*parts, every, strict=True)),
        np.zeros((int(known.sum()), int(known.sum()))),
    )
    samples = end.residuals.size
    meat = meat * (samples / max(samples - int(free.sum()), 1))
    found = np.full(inverse.shape, np.nan)
    part_inverse = inverse[np.ix_(known, known)]
    found[np.ix_(known, known)] = part_inverse @ meat @ part_inverse
    return found


def _estimates(
    search: _Search, point: Array, covariance: Array
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


def _unit(search: _Search, name: str) -> str:
    return next(one.unit for one in search.model.parameters if one.name == name)
