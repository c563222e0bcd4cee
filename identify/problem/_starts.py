"""Where a search begins: a linear fit by projection, and physical initial guesses of effects."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from servosight.identify.problem._problem import Problem
from servosight.models.core import TORQUE, Array, Mask, Recording, rms
from servosight.models.effects import Effect, GuessFeatures, ResidualFeatures
from servosight.models.plant import loop_filter

Masks = tuple[Mask, ...]

_TIME_CONSTANTS = np.geomspace(2e-3, 0.6, 14)
_SHORTER_LAGS = (0.5, 0.2)
_LONGER_TIMES = (1.0, 2.0)
_DAMPING_RATIOS = np.array([0.25, 0.6, 1.2, 3.0])


def linear_start(problem: Problem) -> Array:
    """Best of a grid over T and xi, with k and each bias by regression (variable projection).

    Golub and Pereyra, Inverse Problems 19 (2003). Returns a search point of the linear problem.
    """
    grid = np.array(list(itertools.product(np.log(_TIME_CONSTANTS), np.log(_DAMPING_RATIOS))))
    points = np.zeros((len(grid), len(problem.coordinates)))
    points[:, 0] = 1.0
    low, high = problem.bounds
    points[:, 1:3] = np.clip(grid, low[1:3], high[1:3])
    first = problem.physical
    for r, recording in enumerate(problem.recordings):
        points[:, first + 3 * r + 1] = recording.command_deg[0]
    shapes = problem.predict(points)
    measured = [recording.angle_deg for recording in problem.recordings]
    centred = [shape - shape.mean(axis=1, keepdims=True) for shape in shapes]
    numerator = sum(c @ (m - m.mean()) for c, m in zip(centred, measured, strict=True))
    denominator = sum(np.einsum("ij,ij->i", c, c) for c in centred)
    gain = np.clip(numerator / np.maximum(denominator, 1e-12), low[0], high[0])
    spread = sum(
        np.sum((m - m.mean() - g[:, None] * c) ** 2, axis=1)
        for g, c, m in zip(itertools.repeat(gain), centred, measured, strict=False)
    )
    best = int(np.argmin(spread))
    point = points[best].copy()
    point[0] = gain[best]
    for r, recording in enumerate(problem.recordings):
        own = first + 3 * r
        point[own] = recording.angle_deg.mean() - gain[best] * shapes[r][best].mean()
        point[own + 1] = recording.angle_deg[:3].mean()
        point[own + 2] = 0.0
    return np.asarray(np.clip(point, low, high))


def _followed(problem: Problem, point: Array) -> list[Array]:
    """Angles of a fit (a search point), (samples,) each; as measured where its steps ran out.

    Samples that are held out do not keep a fit from a model that takes more steps than are allowed.
    """
    return [
        np.where(np.isfinite(angles[0]), angles[0], recording.angle_deg)
        for recording, angles in zip(problem.recordings, problem.predict(point), strict=True)
    ]


def _mean_setup(recordings: Sequence[Recording]) -> tuple[float, float]:
    """The geometric means of the recordings' relative gains and loads."""
    setups = [(one.relative_gain, one.relative_load) for one in recordings]
    gain, load = np.exp(np.log(setups).mean(axis=0))
    return float(gain), float(load)


def guess_features(problem: Problem, point: Array) -> GuessFeatures:
    """Initial-guess features: sizes, from the recordings and a fit (a search point).

    Torques and T are those at the mean gain of the recordings, where their residuals are.
    """
    residual = problem.residuals(point[None, :])[0]
    speeds, drives, ranges = [], [], []
    values, mean = problem.values(point), _mean_setup(problem.recordings)
    followed = _followed(problem, point)
    for r, (recording, angles) in enumerate(zip(problem.recordings, followed, strict=True)):
        bias = point[problem.physical + 3 * r]
        speeds.append(np.max(np.abs(np.gradient(angles, recording.time_s))))
        command = recording.command_at(recording.time_s)
        drive = np.max(np.abs(values["k"] * command + bias - angles))
        own = TORQUE.factor(recording.relative_gain, recording.relative_load)
        drives.append(drive / own * TORQUE.factor(*mean))
        ranges.append(0.5 * recording.moved_range_deg)
    return GuessFeatures(
        residual_deg=rms(residual),
        amplitude_deg=float(max(ranges)),
        speed_deg_s=float(max(max(speeds), 1.0)),
        drive_deg=float(max(max(drives), 0.1)),
        T_s=values["T"] * problem.coordinates[1].parameter.scaling.factor(*mean),
        curves=residual_features(problem, point),
    )


def residual_features(problem: Problem, point: Array) -> ResidualFeatures:
    """Residual features: recordings and a fit (a search point), sample by sample, joined."""
    k = problem.values(point)["k"]
    columns: list[tuple[Array, ...]] = []
    intervals = [float(np.median(np.diff(one.time_s))) for one in problem.recordings]
    followed = _followed(problem, point)
    for r, (recording, model) in enumerate(zip(problem.recordings, followed, strict=True)):
        command = recording.command_at(recording.time_s)
        angle = recording.angle_deg
        speed = np.gradient(angle, recording.time_s)
        drive = k * command + point[problem.physical + 3 * r] - angle
        pushed = recording.disturbance_at(recording.time_s)
        asked = np.gradient(command, recording.time_s)
        columns.append((command, angle, speed, drive, angle - model, pushed, asked))
    edges = np.cumsum([recording.time_s.size for recording in problem.recordings])[:-1]

    lags = [problem.rows(point[None, :], r)[0, 1:3] for r in range(len(intervals))]
    filters = [loop_filter(T, xi, dt) for (T, xi), dt in zip(lags, intervals, strict=True)]

    def respond(torques: Array) -> Array:
        parts = zip(filters, np.split(torques, edges, axis=1), strict=True)
        return np.concatenate([problem.plant.filtered(*of, part) for of, part in parts], axis=1)

    joined = (np.concatenate(column) for column in zip(*columns, strict=True))
    command, angle, speed, drive, residual, pushed, asked = joined
    return ResidualFeatures(
        command, angle, speed, drive, residual, intervals[-1], k, respond, pushed, asked
    )


@dataclass(frozen=True)
class BaseModel:
    """A fitted model from which models with more effects start; what they need of it is cached.

    For each set of effects ``changes`` caches masks, starts and the costs of these under the masks,
    and ``ordered`` masks and the starts ordered under them.
    """

    problem: Problem
    point: Array
    changes: dict[tuple[str, ...], tuple[Masks, Array, Array]] = field(
        default_factory=dict, compare=False
    )
    ordered: dict[tuple[str, ...], tuple[Masks, Array]] = field(default_factory=dict, compare=False)
    _guesses: dict[str, tuple[tuple[float, ...], ...]] = field(default_factory=dict, compare=False)

    @functools.cached_property
    def guess_features(self) -> GuessFeatures:
        """Initial-guess features of the model's residual."""

        return guess_features(self.problem, self.point)

    def guesses(self, effect: Effect) -> tuple[tuple[float, ...], ...]:
        """The effect's own guesses of its parameters, at relative gain and load 1."""
        if effect.id not in self._guesses:
            mean = _mean_setup(self.problem.recordings)
            factors = [parameter.scaling.factor(*mean) for parameter in effect.parameters]
            self._guesses[effect.id] = tuple(
                tuple(value / factor for value, factor in zip(guess, factors, strict=True))
                for guess in effect.guesses(self.guess_features)
            )
        return self._guesses[effect.id]


def effect_guesses(problem: Problem, base: BaseModel) -> list[Array]:
    """Search points of ``problem``: the base's point, with guesses for effects it lacks.

    All combinations of the new effects' guesses.
    """
    new = _new(problem, base)
    every = itertools.product(*(base.guesses(effect) for effect in new))
    return [_guessed(problem, base, dict(zip(new, guesses, strict=True))) for guesses in every]


def _new(problem: Problem, base: BaseModel) -> list[Effect]:
    """The effects of ``problem`` that the base lacks."""
    lacked = set(problem.effects) - set(base.problem.effects)
    return [effect for effect in problem.plant.layout.effects if effect.id in lacked]


def _guessed(
    problem: Problem, base: BaseModel, guesses: Mapping[Effect, tuple[float, ...]]
) -> Array:
    """The base's point with a guess for each effect that it lacks."""
    coordinates = base.problem.coordinates
    known = {(c.name, c.recording): x for c, x in zip(coordinates, base.point, strict=True)}
    guess = {
        f"{effect.id}.{parameter.name}": value
        for effect, values in guesses.items()
        for parameter, value in zip(effect.parameters, values, strict=True)
    }
    start = [
        known[(c.name, c.recording)]
        if (c.name, c.recording) in known
        else c.to_search(guess[c.name])
        for c in problem.coordinates
    ]
    return np.asarray(np.clip(start, *problem.bounds))


def effect_starts(problem: Problem, base: BaseModel) -> list[Array]:
    """The guesses, each with the lag 2 xi T as it is and shorter, or longer by a lead.

    A model that lacks a limit or friction fits their delay by a longer lag. A shorter lag is not
    kept overdamped: its time constant would be shorter than any servo's. One that lacks a lead fits
    it by a shorter lag, and by a shorter time constant.
    """
    leads = [f"{effect.id}.{effect.lead}" for effect in _new(problem, base) if effect.lead]
    early = [c.name in leads for c in problem.coordinates]
    found: list[Array] = []
    for guess in effect_guesses(problem, base):
        if any(early):
            lead = float(guess[early].sum())
            found += [guess, *(_longer(guess, lead, times) for times in _LONGER_TIMES)]
        else:
            found += [guess, *(_shorter(guess, share) for share in _SHORTER_LAGS)]
    return [np.clip(point, *problem.bounds) for point in found]


def _shorter(point: Array, share: float) -> Array:
    """A search point with ``share`` of its lag, critically damped at most."""
    found = point.copy()
    found[2] = min(point[2], 0.0)
    found[1] += np.log(share) + point[2] - found[2]
    return found


def _longer(point: Array, lead_s: float, times: float) -> Array:
    """A search point with a lag longer by ``lead_s``, and ``times`` its time constant."""
    found = point.copy()
    found[1] += np.log(times)
    lag = 2.0 * np.exp(point[1] + point[2]) + lead_s
    found[2] = np.log(0.5 * lag) - found[1]
    return found


def neutral_start(problem: Problem, base: BaseModel) -> Array:
    """The search point of ``problem`` at which the effects that the base lacks are neutral."""
    owned = {
        (c.name, c.recording): float(x)
        for c, x in zip(base.problem.coordinates, base.point, strict=True)
    }
    low, high = problem.bounds
    guesses = {effect: base.guesses(effect) for effect in _new(problem, base)}
    if all(guesses.values()):
        start = _guessed(problem, base, {effect: own[0] for effect, own in guesses.items()})
    else:
        start = 0.5 * (low + high)  # terms of a law have no guesses
    for j, coordinate in enumerate(problem.coordinates):
        neutral, key = coordinate.parameter.neutral, (coordinate.name, coordinate.recording)
        if key in owned:
            start[j] = owned[key]
        elif neutral is not None:
            start[j] = coordinate.to_search(neutral)
    return np.asarray(np.clip(start, low, high))


def search_box(problem: Problem, linear: BaseModel) -> tuple[Array, Array]:
    """Bounds for a population about a linear start: wide, but finite and physical."""
    low, high = (bound.copy() for bound in problem.bounds)
    coordinates = linear.problem.coordinates
    at = {(c.name, c.recording): x for c, x in zip(coordinates, linear.point, strict=True)}
    guesses = {
        f"{effect.id}.{parameter.name}": [start[j] for start in linear.guesses(effect)]
        for effect in problem.plant.layout.effects
        if effect.id in problem.effects
        for j, parameter in enumerate(effect.parameters)
    }
    for j, c in enumerate(problem.coordinates):
        centre = at.get((c.name, c.recording))
        if centre is None:
            searched = [c.to_search(value) for value in guesses[c.name]]
            largest = 3.0 * max(abs(value) for value in searched) + 1e-9
            low[j] = max(low[j], -largest if min(searched) < 0.0 else 0.0)
            high[j] = min(high[j], largest)
        else:
            reach = {"k": 0.5 * abs(centre) + 0.1, "T": 1.6, "xi": 1.6}.get(
                c.name, 0.25 * linear.guess_features.amplitude_deg + 1.0
            )
            if c.name == "initial_speed":
                reach = 0.1 * linear.guess_features.speed_deg_s
            low[j] = max(low[j], centre - reach)
            high[j] = min(high[j], centre + reach)
    held = problem.is_held
    low[held] = high[held] = problem.bounds[0][held]
    return low, high
