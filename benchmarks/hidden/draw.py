"""Trials of the hidden-effect benchmark: what is hidden, in which servo, seen how.

A trial is a row of the table and a seed. Its strength is what the row asks for: the noise is set by
the misfit of the best model that lacks one of the hidden effects, without noise.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from hashlib import sha256

import numpy as np

from servosight.models import excitation as shapes
from servosight.models.core import Array, Camera, Recording
from servosight.models.effects import catalogue
from servosight.models.excitation import Excitation
from servosight.scenarios.draws import DRAWS, SHOWN_ALONE, scaled
from servosight.scenarios.settings import LinearServo
from servosight.sim.bench import Trajectory
from servosight.sim.run import angle_recording

from .truth import TRUTHS, known, outside

NOISE_DEG = (0.01, 0.3)
FILMED_DEG = 0.02
"""Through the video the tolerance counts, 0.05 % of the range; the tracker's noise is far below."""
RATES_HZ = (30.0, 60.0, 120.0, 240.0)
SIZE = (0.1, 1.5)
"""An effect's distance from neutral, as a share of what scenarios/draws.py draws."""
ADDED = ("current_limit", "motion_profile", "velocity_feedforward")
"""Effects that the catalogue has received since the first measurement, in their order."""
SENDERS_HZ = (50.0, 100.0, 250.0)
DURATION_S = (6.0, 10.0)


@dataclass(frozen=True)
class TableRow:
    """One row of the table: how many effects are hidden, how strong, by which truths."""

    hidden: int
    strength: tuple[float, float]
    truths: tuple[str, ...] = ("twin", "fixed steps")
    coarse: bool = False
    outside: bool = False
    filmed: bool = False


ROWS: Mapping[str, TableRow] = {
    "single": TableRow(1, (3.0, 30.0)),
    "weak": TableRow(1, (1.5, 3.0)),
    "faint": TableRow(1, (0.75, 1.5)),
    "nothing": TableRow(0, (0.0, 0.0), ("twin",)),
    "pair": TableRow(2, (3.0, 30.0)),
    "coarse": TableRow(1, (1.5, 30.0), coarse=True),
    "outside": TableRow(1, (3.0, 30.0), outside=True),
    "equation": TableRow(1, (3.0, 30.0), ("equation",)),
    "video": TableRow(1, (3.0, 30.0), filmed=True),
}


@dataclass(frozen=True)
class TrialSetup:
    """Everything of a trial but its noise; ``wish`` in 0 to 1 places it within the row's range."""

    row: str
    seed: int
    attempt: int
    truth: str
    servo: LinearServo
    effects: Mapping[str, Mapping[str, float]]
    excitation: Excitation
    camera: Camera
    with_sigma: bool
    wish: float

    @property
    def name(self) -> str:
        """Row and seed."""
        return f"{self.row} {self.seed}"

    def trajectory(self) -> Trajectory:
        """What the servo does."""
        return TRUTHS[self.truth](self.servo, self.effects, self.excitation)

    def stream(self, number: int) -> int:
        """A seed for one source of noise, of its own for each trial."""
        return int(np.random.SeedSequence([self.seed, self.attempt, number]).generate_state(1)[0])

    def record(self, noise_deg: float) -> Recording:
        """The angles that the camera sees, with noise."""
        return angle_recording(
            self.trajectory(),
            self.camera,
            noise_deg,
            self.stream(7),
            name=self.name,
            with_sigma=self.with_sigma,
        )


def propose(row_name: str, seed: int, attempt: int) -> TrialSetup:
    """The ``attempt``-th draw of a trial. Effects take turns with the seed, the rest is random."""
    row = ROWS[row_name]
    rng = np.random.default_rng([seed, list(ROWS).index(row_name), attempt])
    names, turn = choice(row_name, seed)
    truths = [t for t in row.truths if set(names) <= {*(outside if row.outside else known)(t)}]
    truth = truths[turn % len(truths)]
    effects = {name: _values(name, truth, rng) for name in names}
    bias = float(rng.uniform(-2.0, 2.0))
    for name in names:
        if name in DRAWS and DRAWS[name].trimmed:
            bias += effects[name][DRAWS[name].trimmed]
    servo = LinearServo(
        k=float(rng.uniform(0.8, 1.2)),
        T=_log_uniform(rng, 0.012, 0.05),
        xi=float(rng.uniform(0.35, 1.2)),
        bias=bias,
    )
    rate_hz = float(rng.choice(RATES_HZ))
    if row.coarse and seed % 2:
        rate_hz = 30.0
    return TrialSetup(
        row_name,
        seed,
        attempt,
        truth,
        servo,
        effects,
        mixture(rng, float(rng.uniform(*DURATION_S)), float(rng.uniform(12.0, 35.0))),
        Camera(rate_hz=rate_hz, exposure_s=float(rng.uniform(0.0, 0.3)) / rate_hz),
        bool(rng.uniform() < 0.67),
        float(rng.uniform()),
    )


def noise_for(setup: TrialSetup, weakest_deg: float) -> float | None:
    """The noise [deg] that gives a strength within the row's range; None where no noise does.

    ``weakest_deg`` is the misfit of the best model that lacks one of the hidden effects.
    """
    row = ROWS[setup.row]
    least, most = NOISE_DEG
    if row.filmed:
        least = most = FILMED_DEG
    if row.coarse and setup.seed % 2 == 0:
        least = 0.2
    if row.hidden:
        least, most = (
            max(least, weakest_deg / row.strength[1]),
            min(most, weakest_deg / row.strength[0]),
        )
    if not least <= most:
        return None
    return float(least * (most / least) ** setup.wish)


def mixture(rng: np.random.Generator, duration_s: float, amplitude_deg: float) -> Excitation:
    """Rest, then three to five shapes for random times, each at full or at a lower amplitude."""
    rate_hz = float(rng.choice(SENDERS_HZ))
    time_s = np.arange(round(duration_s * rate_hz) + 1) / rate_hz
    command = np.zeros_like(time_s)
    chosen = rng.permutation(5)[: int(rng.integers(3, 6))]
    shares = rng.dirichlet(np.full(chosen.size, 8.0))
    edges = 0.5 + (duration_s - 0.5) * np.concatenate([[0.0], np.cumsum(shares)])
    for kind, start, end in zip(chosen, edges[:-1], edges[1:], strict=True):
        inside = (time_s >= start) & (time_s <= end)
        size = amplitude_deg * float(rng.choice((1.0, 0.7, 0.25)))
        command[inside] = _shape(int(kind), time_s[inside], size, rng)
    return Excitation(time_s, command)


def _shape(kind: int, time_s: Array, size: float, rng: np.random.Generator) -> Array:
    seed = int(rng.integers(2**31))
    if kind == 0:
        return shapes.steps(time_s, size, float(rng.uniform(0.3, 0.9)), seed)
    if kind == 1:
        return shapes.chirp(time_s, 0.6 * size, 0.3, float(rng.uniform(6.0, 14.0)))
    if kind == 2:
        return shapes.triangle(time_s, 0.8 * size, float(rng.uniform(0.3, 1.0)))
    if kind == 3:
        return shapes.triangle(time_s, 0.2 * size, float(rng.uniform(0.5, 2.0)))
    return shapes.multisine(time_s, 0.8 * size, 0.5, float(rng.uniform(5.0, 12.0)), seed)


def choice(row_name: str, seed: int) -> tuple[tuple[str, ...], int]:
    """What a seed of a row hides, and how many seeds before it had their turn with the same.

    Seeds take turns through the sets without :data:`ADDED`. A set that came later takes its share
    of the seeds, those that its hash picks, and leaves the others what they had.
    """
    sets = choices(row_name)
    first = sum(not set(ADDED) & set(names) for names in sets)
    chosen = sets[seed % first]
    for count, names in enumerate(sets[first:], start=first + 1):
        digest = sha256(f"{seed} {' '.join(names)}".encode()).digest()
        if int.from_bytes(digest[:8], "little") * count < 2**64:
            chosen = names
    return chosen, seed // first


def choices(row_name: str) -> list[tuple[str, ...]]:
    """All sets of effects that a row can hide, those with :data:`ADDED` ones behind, in order."""
    row = ROWS[row_name]
    if row.outside:
        return [(name,) for truth in row.truths for name in outside(truth)]
    able = {name for truth in row.truths for name in known(truth) if name in SHOWN_ALONE}
    names = [name for name in catalogue() if name in able]
    sets = itertools.combinations(names, row.hidden)
    found = [s for s in sets if any(set(s) <= set(known(truth)) for truth in row.truths)]
    return sorted(found, key=lambda names: max((ADDED.index(n) + 1 for n in names if n in ADDED),
                                               default=0))  # fmt: skip


def _values(name: str, truth: str, rng: np.random.Generator) -> dict[str, float]:
    """Parameters of an effect: drawn from its ranges; a catalogued one of any size."""
    if name in outside(truth):
        return {key: float(rng.uniform(*span)) for key, span in outside(truth)[name].items()}
    effect = catalogue()[name]
    drawn = {key: float(rng.uniform(*span)) for key, span in DRAWS[name].parameters.items()}
    found = {parameter.name: float(parameter.neutral or 0.0) for parameter in effect.parameters}
    for key, value in scaled(name, drawn, _log_uniform(rng, *SIZE)).items():
        parameter = effect.parameter(key)
        found[key] = min(max(value, parameter.low), parameter.high)
    return found


def _log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))
