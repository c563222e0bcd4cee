"""Fisher information: which parameters a command determines, before or after a fit.

Fisher information of white noise: F = J'J / noise^2 with J the change of the angle for relative
changes of the parameters; each recording's own numbers (bias, initial state) are projected out
(Seber and Wild, Nonlinear Regression, 1989, section 2.1; Ljung, System Identification, 1999,
section 13.3).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from servosight.identify.problem import (
    TOLERANCE_SHARE,
    Problem,
    coordinate_scale,
    difference_quotient,
    projected_out,
)
from servosight.models.core import Array, Frozen, plain, rounded

ENOUGH = 0.05
"""A parameter counts as determined where its predicted sigma is at most this share of it."""
MOVE = 0.10
"""The worst-determined direction is described at this relative change."""
NAMED = 0.25
"""Parameters with less than this share of a direction's largest part are not named."""
COHERENT = 0.25
"""Share of the tolerance by which a model's own error may line up with one direction."""
_FLAT = 1e-13
_SMALLEST_DEG = 1e-9


@dataclass(frozen=True)
class Direction(Frozen):
    """A joint relative change of parameters, and the rms change of the angle that is left of it.

    What each recording's own numbers can take up is not counted.
    """

    change: Mapping[str, float]
    difference_deg: float

    def words(self, noise_deg: float, blur_deg: float, several: str) -> str:
        """The direction in words; a model may be wrong by ``blur_deg``.

        ``several`` is what is said of the parameters where more than one is named.
        """
        largest = max(abs(part) for part in self.change.values())
        named = {n: p for n, p in self.change.items() if abs(p) >= NAMED * largest}
        moves = [
            f"{'raising' if part > 0.0 else 'lowering'} {name} by {percent(abs(part))}"
            for name, part in named.items()
        ]
        size = f"changes the angle by {rounded(self.difference_deg, 2)} deg rms, "
        if self.difference_deg < noise_deg:
            size += f"less than the noise of {rounded(noise_deg, 2)} deg"
        elif self.difference_deg < blur_deg:
            size += f"less than the {rounded(blur_deg, 2)} deg to which a model may be wrong"
        else:
            size += f"{rounded(self.difference_deg / noise_deg, 2)} times the noise"
        if len(named) == 1:
            return f"{next(iter(named))} is determined worst: {moves[0]} {size}"
        return f"{_and(list(named))} {several}: {_and(moves)} {size}"


@dataclass(frozen=True)
class WorstDirection(Frozen):
    """Joint relative change of parameters, and the rms change of the angle that it makes [deg]."""

    relative_change: Mapping[str, float]
    difference_deg: float


@dataclass(frozen=True, eq=False)
class InformationSummary(Frozen):
    """Whether a command determines the parameters, as plain values: the keys of its JSON.

    ``per_second`` (parameters, parameters) is the Fisher information for relative changes.
    """

    sufficient: bool
    unsure: tuple[str, ...]
    sentence: str
    parameters: tuple[str, ...]
    per_second: Array
    relative_sigma: Mapping[str, float | None]
    condition: float | None
    worst_direction: WorstDirection
    noise_deg: float
    duration_s: float


@dataclass(frozen=True)
class Information:
    """Information of a command about the parameters ``names``, for relative changes.

    ``fisher`` (names, names) over all of ``duration_s``. A change of the angle below ``blur_deg``
    determines nothing, however long the recording: no model is accurate to that.
    """

    names: tuple[str, ...]
    fisher: Array
    duration_s: float
    samples: int
    noise_deg: float
    blur_deg: float

    @property
    def per_second(self) -> Array:
        """Fisher information a second, (names, names)."""
        return self.fisher / self.duration_s

    @property
    def sigma(self) -> dict[str, float]:
        """Predicted standard deviation over value of each parameter; infinite where it is lost."""
        values, vectors = _eigen(self.fisher)
        lost = values <= _FLAT * max(float(values[-1]), 1e-300)
        with np.errstate(divide="ignore"):
            parts = np.where(lost, 0.0, 1.0 / np.maximum(values, 1e-300))
        spread = np.sqrt(vectors**2 @ parts)
        spread[np.sum(vectors[:, lost] ** 2, axis=1) > 1e-6] = np.inf
        return dict(zip(self.names, spread.tolist(), strict=True))

    @property
    def condition(self) -> float:
        """Largest over smallest eigenvalue of the information; infinite where one is flat."""
        values, _ = _eigen(self.fisher)
        if values[0] <= _FLAT * values[-1]:
            return float(np.inf)
        return float(values[-1] / values[0])

    @property
    def worst(self) -> Direction:
        """The direction that changes the angle least, with its largest part at ten percent."""
        values, vectors = _eigen(self.fisher)
        part = vectors[:, 0] * np.sign(vectors[np.argmax(np.abs(vectors[:, 0])), 0])
        move = MOVE / float(np.max(np.abs(part)))
        change = dict(zip(self.names, (move * part).tolist(), strict=True))
        rms = move * np.sqrt(max(float(values[0]), 0.0) / self.samples) * self.noise_deg
        return Direction(change, float(rms))

    @property
    def unsure(self) -> tuple[str, ...]:
        """Parameters that this command does not determine, most uncertain first.

        Their sigma exceeds five percent, or they have a large part in a direction whose effect
        stays below ``blur_deg``.
        """
        sigma = self.sigma
        found = {name for name, spread in sigma.items() if spread > ENOUGH}
        if self.worst.difference_deg < self.blur_deg:
            change = self.worst.change
            found |= {name for name, part in change.items() if abs(part) >= NAMED * MOVE}
        return tuple(sorted(found, key=lambda name: -sigma[name]))

    @property
    def sufficient(self) -> bool:
        """True where every parameter is determined."""
        return not self.unsure

    @property
    def sentence(self) -> str:
        """The verdict in words, with the worst-determined direction."""
        if self.sufficient:
            spread = max(self.sigma.values())
            words = self.worst.words(self.noise_deg, self.blur_deg, "together are determined worst")
            return (
                f"The command determines {_and(list(self.names))} to {percent(spread)} or better; "
                f"{words}."
            )
        words = self.worst.words(self.noise_deg, self.blur_deg, "are determined only together")
        (first, *more) = self.unsure
        alone = f"{first} is determined worst"
        words = words.removeprefix(alone) if not more else f"; {words}"
        return f"The command does not determine {_and(list(self.unsure))}{words}."

    def to_dict(self) -> dict[str, Any]:
        """The summary's JSON."""
        found: dict[str, Any] = plain(self.summary())
        return found

    def summary(self) -> InformationSummary:
        """The same as plain values; None where infinite."""
        worst = self.worst
        return InformationSummary(
            sufficient=self.sufficient,
            unsure=self.unsure,
            sentence=self.sentence,
            parameters=self.names,
            per_second=self.per_second,
            relative_sigma={
                name: spread if np.isfinite(spread) else None for name, spread in self.sigma.items()
            },
            condition=self.condition if np.isfinite(self.condition) else None,
            worst_direction=WorstDirection(dict(worst.change), worst.difference_deg),
            noise_deg=self.noise_deg,
            duration_s=self.duration_s,
        )


def information(problem: Problem, point: Array, noise_deg: float) -> Information:
    """Information of ``problem``'s commands about the shared parameters at a search point.

    Parameters that stand at zero have no relative change: they are projected out with the
    recordings' own.
    """
    jacobian = difference_quotient(problem, point, coordinate_scale(problem, point))
    scale = relative_scale(problem, point)
    judged = np.flatnonzero(scale)
    own = np.setdiff1d(np.arange(jacobian.shape[1]), judged)
    noise = max(noise_deg, _SMALLEST_DEG)
    rest = projected_out(jacobian[:, judged] * scale[judged], jacobian[:, own])
    moved = max(float(np.ptp(angles[0])) for angles in problem.predict(point))
    return Information(
        tuple(problem.coordinates[j].name for j in judged),
        rest.T @ rest / noise**2,
        sum(recording.duration_s for recording in problem.recordings),
        jacobian.shape[0],
        noise,
        COHERENT * TOLERANCE_SHARE * moved,
    )


def relative_scale(problem: Problem, point: Array) -> Array:
    """d coordinate / d ln(value) of free shared parameters, 0 for the others, (coordinates,)."""
    scale, is_held = np.zeros(point.size), problem.is_held
    for j, coordinate in enumerate(problem.coordinates[: problem.physical]):
        x = float(point[j])
        if x != 0.0 and not is_held[j]:
            scale[j] = coordinate.from_search(x) / coordinate.slope(x)
    return scale


def _eigen(fisher: Array) -> tuple[Array, Array]:
    values, vectors = np.linalg.eigh(fisher)
    return np.asarray(values), np.asarray(vectors)


def percent(share: float) -> str:
    return "no finite value" if not np.isfinite(share) else f"{rounded(100.0 * share, 2)} %"


def _and(words: Sequence[str]) -> str:
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
