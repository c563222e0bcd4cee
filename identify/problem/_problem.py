"""The fit as a search problem: recordings and free parameters in, residuals out.

Coordinates of the search: k as it is, T and xi as logarithms, effects' parameters as they are or,
where the neutral value is infinite, as reciprocals; then bias, initial angle and initial speed of
each recording.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from servosight.identify.problem._restarts import restarts
from servosight.identify.problem._work import Work
from servosight.identify.problem.noise import sample_noise_deg, standstill_errors
from servosight.identify.problem.samples import sample_weights
from servosight.models.core import CORE, OWN, Array, Mask, Parameter, Recording
from servosight.models.effects import Effect
from servosight.models.plant import Plant, Stimulus

LOST_DEG = 1e6
"""The error [deg] of a sample that was not simulated, and the largest that counts."""
_JOINED_DEG = 5e-4  # below what logs resolve: angles change by 0.001 deg rms at most


@dataclass(frozen=True)
class Coordinate:
    """One free number of the search: its column in a row of plant parameters, and its mapping.

    ``recording`` is None for a physical parameter that all recordings share.
    """

    name: str
    parameter: Parameter
    column: int
    recording: int | None = None

    @property
    def logarithmic(self) -> bool:
        """True for the positive parameters of the linear core."""
        return self.name in ("T", "xi")

    def to_search(self, value: float) -> float:
        """Physical value to coordinate."""
        return float(np.log(value)) if self.logarithmic else self.parameter.to_search(value)

    def from_search(self, coordinate: float) -> float:
        """Coordinate to physical value."""
        if self.logarithmic:
            return float(np.exp(coordinate))
        return self.parameter.from_search(coordinate)

    def slope(self, coordinate: float) -> float:
        """d value / d coordinate, to carry a sigma over."""
        if self.logarithmic:
            return float(np.exp(coordinate))
        if self.parameter.reciprocal:
            return float(-1.0 / max(coordinate * coordinate, 1e-300))
        return 1.0

    @property
    def bounds(self) -> tuple[float, float]:
        """Bounds of the coordinate."""
        low, high = self.parameter.search_bounds
        if self.logarithmic:
            return float(np.log(low)), float(np.log(high))
        return low, high


@dataclass(frozen=True)
class Problem:
    """Fit ``effects`` (with the linear core) to ``recordings``.

    ``masks`` (one boolean array a recording) marks the samples that are scored; the simulation
    passes through all of them. Residuals are (measured - model) * weight, with weights about one,
    so that a cost stays in degrees. ``ranges`` are narrower bounds by name of a parameter of the
    linear core, or of ``bias``. ``held`` parameters stay at their values: their bounds are these.
    Those of effects that are not fitted are ignored. ``work`` counts the simulations and keeps the
    last. ``horizon_s``: the model predicts so far at a time, beginning anew from the measured
    motion; the whole recording if None. ``noises_deg`` is the noise of each recording where it was
    estimated already.
    """

    recordings: tuple[Recording, ...]
    plant: Plant
    effects: tuple[str, ...]
    masks: tuple[Mask, ...]
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    held: Mapping[str, float] = field(default_factory=dict)
    horizon_s: float | None = None
    work: Work = field(default_factory=Work, compare=False)
    noises_deg: tuple[float, ...] | None = field(default=None, compare=False)

    @classmethod
    def of(
        cls,
        recordings: Sequence[Recording],
        catalogue: Mapping[str, Effect],
        effects: Sequence[str],
        masks: Sequence[Mask] | None = None,
        ranges: Mapping[str, tuple[float, float]] | None = None,
        held: Mapping[str, float] | None = None,
        work: Work | None = None,
        horizon_s: float | None = None,
        noises_deg: tuple[float, ...] | None = None,
    ) -> Problem:
        """A problem over the catalogue's plant; all samples are scored unless masks say less."""
        if masks is None:
            masks = [np.ones(recording.time_s.size, dtype=bool) for recording in recordings]
        return cls(
            tuple(recordings),
            Plant.of(catalogue),
            tuple(effects),
            tuple(masks),
            dict(ranges or {}),
            dict(held or {}),
            horizon_s,
            Work() if work is None else work,
            noises_deg,
        )

    @property
    def linear(self) -> Problem:
        """The same recordings and held parameters without any effect."""
        return replace(self, effects=(), ranges={})

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The free numbers, shared ones first."""
        found = [Coordinate(q.name, q, i) for i, q in enumerate(CORE)]
        layout = self.plant.layout
        for effect, offset in zip(layout.effects, layout.offsets, strict=True):
            if effect.id in self.effects:
                found += [
                    Coordinate(f"{effect.id}.{q.name}", q, offset + j)
                    for j, q in enumerate(effect.parameters)
                ]
        for r in range(len(self.recordings)):
            found += [Coordinate(q.name, q, len(CORE) + j, r) for j, q in enumerate(OWN)]
        return tuple(found)

    @property
    def physical(self) -> int:
        """How many coordinates are shared by all recordings."""
        return len(self.coordinates) - len(OWN) * len(self.recordings)

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of the search, each (coordinates,)."""
        pairs = np.array([coordinate.bounds for coordinate in self.coordinates])
        for j, coordinate in enumerate(self.coordinates):
            if coordinate.recording is None and coordinate.name in self.held:
                pairs[j] = coordinate.to_search(self.held[coordinate.name])
            elif coordinate.name in self.ranges:
                pairs[j] = [coordinate.to_search(end) for end in self.ranges[coordinate.name]]
            elif coordinate.recording is not None and coordinate.name == "initial_speed":
                fastest = _fastest_deg_s(self.recordings[coordinate.recording])
                pairs[j] = np.clip(pairs[j], -fastest, fastest)
        return pairs[:, 0], pairs[:, 1]

    @property
    def is_held(self) -> Mask:
        """True for coordinates that are held, (coordinates,)."""
        low, high = self.bounds
        return np.asarray(low == high)

    @property
    def fitted(self) -> int:
        """How many of the shared coordinates are free."""
        return self.physical - int(self.is_held[: self.physical].sum())

    @cached_property
    def stimuli(self) -> tuple[Stimulus, ...]:
        """Command and sample times of each recording, as the plant takes them."""
        whole = [
            replace(Stimulus.of(recording), joined_deg=_JOINED_DEG) for recording in self.recordings
        ]
        if self.horizon_s is None or not self.plant.restartable:
            return tuple(whole)
        return tuple(
            replace(stimulus, restarts=restarts(recording, mask, self.horizon_s))
            for stimulus, recording, mask in zip(whole, self.recordings, self.masks, strict=True)
        )

    @cached_property
    def weights(self) -> tuple[Array, ...]:
        """For each recording its samples' weights: ones where no sigma is known."""
        return sample_weights(self.recordings)

    @cached_property
    def sample_noises_deg(self) -> tuple[Array, ...]:
        """For each recording the standard deviation of its measured angles [deg], (samples,)."""
        known = self.noises_deg or itertools.repeat(None)
        return tuple(map(sample_noise_deg, self.recordings, known))

    @cached_property
    def shared(self) -> Array:
        """Change of the weighted residuals by one sigma of each error that a recording's samples
        share, (scored, errors); an error belongs to one recording."""
        scored = sum(int(mask.sum()) for mask in self.masks)
        columns, begin = [np.zeros((scored, 0))], 0
        for recording, weight, mask in zip(self.recordings, self.weights, self.masks, strict=True):
            end = begin + int(mask.sum())
            if recording.shared_deg is not None:
                errors = np.hstack([recording.shared_deg, standstill_errors(recording)])
                own = np.zeros((scored, errors.shape[1]))
                own[begin:end] = (errors * weight[:, None])[mask]
                columns.append(own)
            begin = end
        return np.hstack(columns)

    def rows(self, points: Array, recording: int) -> Array:
        """Rows of plant parameters (batch, width) for search points (batch, coordinates)."""
        batch = np.tile(np.array(self.plant.layout.neutral_row()), (points.shape[0], 1))
        servo = self.recordings[recording]
        for j, coordinate in enumerate(self.coordinates):
            if coordinate.recording in (None, recording):
                column = points[:, j]
                if coordinate.logarithmic:
                    batch[:, coordinate.column] = np.exp(column)
                elif coordinate.parameter.reciprocal:
                    with np.errstate(divide="ignore"):
                        batch[:, coordinate.column] = 1.0 / column
                else:
                    batch[:, coordinate.column] = column
                batch[:, coordinate.column] *= coordinate.parameter.scaling.factor(
                    servo.relative_gain, servo.relative_load
                )
        return batch

    def predict(self, points: Array) -> list[Array]:
        """Model angles for each recording, (batch, samples) each, at search points."""
        points = np.atleast_2d(points)
        return [self._simulated(self.rows(points, r), r) for r in range(len(self.recordings))]

    @cached_property
    def _asked(self) -> tuple[Hashable, ...]:
        """What stands for the plant and each recording's stimulus."""
        return tuple((self.plant.run, stimulus.digest) for stimulus in self.stimuli)

    def _simulated(self, rows: Array, recording: int) -> Array:
        """Each different row once: a parameter of one recording does not change others' rows, and
        one that is held no row."""
        stimulus = self.stimuli[recording]
        asked, duration_s = self._asked[recording], stimulus.duration_s
        return self.work.angles(
            asked, rows, duration_s, lambda new: self.plant.simulate_counted(new, stimulus)
        )

    def residuals(self, points: Array) -> Array:
        """Weighted residuals of the scored samples, (batch, scored); large where it failed."""
        parts = [
            ((recording.angle_deg - angles) * weight)[:, mask]
            for recording, angles, weight, mask in zip(
                self.recordings, self.predict(points), self.weights, self.masks, strict=True
            )
        ]
        joined = np.clip(np.concatenate(parts, axis=1), -LOST_DEG, LOST_DEG)
        return np.nan_to_num(joined, nan=LOST_DEG)

    def values(self, point: Array) -> dict[str, float]:
        """Physical values of the shared parameters at a search point."""
        return {
            coordinate.name: coordinate.from_search(float(x))
            for coordinate, x in zip(self.coordinates, point, strict=True)
            if coordinate.recording is None
        }

    def shared_point(self, value: Callable[[str], float]) -> Array:
        """Search coordinates of the shared parameters, (physical,), each at its name's value."""
        shared = self.coordinates[: self.physical]
        return np.array([coordinate.to_search(value(coordinate.name)) for coordinate in shared])


def _fastest_deg_s(recording: Recording) -> float:
    """No recording begins faster than this: twice the largest speed between its samples [deg/s].

    Noise raises it. A model that begins faster lets an overdamped core jump at the first sample.
    """
    speeds = np.abs(np.diff(recording.angle_deg) / np.diff(recording.time_s))
    return 2.0 * float(np.max(speeds)) + 1.0
