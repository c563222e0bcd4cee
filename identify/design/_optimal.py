"""A command that determines chosen parameters as accurately as limits allow.

The time is divided into slots; a library of short pieces is tried for each. Fisher information adds
up over pieces. Pieces are exchanged as long as the determinant
of the chosen parameters' part grows (D_s-optimal design: Fedorov, Theory of Optimal Experiments,
1972; Goodwin and Payne, Dynamic System Identification, 1977, chapter 6).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from servosight.identify.design._information import Information, relative_scale
from servosight.identify.design._predicted_experiment import (
    assess,
    predicted_experiment,
    resting_point,
)
from servosight.identify.problem import Problem, coordinate_scale, difference_quotient
from servosight.models.core import Actuator, Array, InputError
from servosight.models.effects import Effect
from servosight.models.effects import catalogue as built_in
from servosight.models.excitation import (
    SHAPES,
    CommandLimits,
    Design,
    Excitation,
    Form,
    design,
    slewed,
)

SLOT_S = 1.5
SLOTS = (3, 14)
_PASSES = 4
_RIDGE = 1e-9

_PIECES: tuple[tuple[str, float, Form], ...] = (
    *(("steps", share, Form(dwell_s=0.3)) for share in (1.0, 0.5, 0.2)),
    *(("prbs", share, Form(dwell_s=clock)) for share in (1.0, 0.3) for clock in (0.03, 0.06, 0.12)),
    *(
        ("chirp", share, Form(low_hz=low, high_hz=high))
        for share in (1.0, 0.4)
        for low, high in ((0.8, 5.0), (3.0, 15.0), (8.0, 30.0))
    ),
    *(("triangle", share, Form(frequency_hz=f)) for share in (1.0, 0.3) for f in (1.5, 3.0, 6.0)),
    *(("sine", share, Form(frequency_hz=f)) for share in (1.0, 0.3) for f in (0.7, 1.5, 4.0, 9.0)),
)
"""Shape, share of the angle limit, and form of what fills a slot."""


@dataclass(frozen=True)
class Optimal:
    """The command, and its information about the model for which it was designed."""

    design: Design
    information: Information


@dataclass(frozen=True)
class _Aim:
    """The model, what is wanted of it, and how it will be measured."""

    actuator: Actuator
    wanted: tuple[str, ...]
    catalogue: Mapping[str, Effect]
    frame_rate_hz: float
    noise_deg: float

    def fisher(self, excitation: Excitation) -> tuple[Array, int]:
        """Information about the wanted, then all others and the bias; how many are wanted."""
        recording = predicted_experiment(excitation, self.frame_rate_hz)
        problem = Problem.of([recording], self.catalogue, self.actuator.effects)
        point = resting_point(problem, self.actuator, [self.actuator.value("bias")])
        jacobian = difference_quotient(problem, point, coordinate_scale(problem, point))
        scale = relative_scale(problem, point)
        scale[problem.physical] = 1.0  # the bias, in degrees
        names = [coordinate.name for coordinate in problem.coordinates]
        first = [names.index(name) for name in self.wanted]
        others = np.setdiff1d(np.flatnonzero(scale), first)
        order = np.array([*first, *others], dtype=np.intp)
        columns = jacobian[:, order] * scale[order]
        return columns.T @ columns / self.noise_deg**2, len(first)

    def information(self, made: Design) -> Information:
        """Information of a whole command."""
        recording = predicted_experiment(made.excitation, self.frame_rate_hz)
        return assess(self.actuator, [recording], self.noise_deg, catalogue=self.catalogue)


def optimal(
    actuator: Actuator,
    wanted: Sequence[str],
    limits: CommandLimits,
    *,
    catalogue: Mapping[str, Effect] | None = None,
    frame_rate_hz: float = 120.0,
    noise_deg: float = 0.03,
    seed: int = 0,
) -> Optimal:
    """The command within ``limits`` with the most information about the ``wanted`` parameters.

    Where one of the plain shapes gives more than the mix, it is taken. Raises InputError for
    parameters that the model does not have or that stand at zero.
    """
    _check(actuator, wanted)
    aim = _Aim(actuator, tuple(wanted), catalogue or built_in(), frame_rate_hz, noise_deg)
    still = replace(limits, centre_deg=0.0)
    designs = [_mix(aim, still, seed), *_possible(still, SHAPES, seed)]
    moved = [_about(made, limits.centre_deg) for made in designs]
    best = max(moved, key=lambda made: _criterion(*aim.fisher(made.excitation)))
    return Optimal(best, aim.information(best))


def _mix(aim: _Aim, limits: CommandLimits, seed: int) -> Design:
    """Slots filled by greedy choice, then by exchange."""
    slots = int(np.clip(limits.duration_s / SLOT_S, *SLOTS))
    slot = replace(limits, duration_s=limits.duration_s / slots)
    pieces = list(_pieces(slot, seed))
    results = [aim.fisher(piece.excitation) for piece in pieces]
    count = results[0][1]
    fishers = np.array([fisher for fisher, _ in results])
    chosen: list[int] = []
    total = _RIDGE * np.diag(np.diag(fishers.sum(axis=0)) + 1e-12)
    for _ in range(slots):
        chosen.append(_best(total + fishers, count))
        total = total + fishers[chosen[-1]]
    for _ in range(_PASSES):
        before = list(chosen)
        for i, old in enumerate(chosen):
            total = total - fishers[old]
            chosen[i] = _best(total + fishers, count)
            total = total + fishers[chosen[i]]
        if chosen == before:
            break
    rows = np.concatenate([pieces[i].excitation.command_deg[:-1] for i in sorted(chosen)])
    command = slewed(np.append(rows, 0.0), limits)
    counted = Counter(pieces[i].words for i in sorted(chosen))
    words = "; ".join(f"{slot.duration_s * n:.3g} s of {what}" for what, n in counted.items())
    return Design(Excitation(np.arange(command.size) / limits.rows_hz, command), words)


def _pieces(slot: CommandLimits, seed: int) -> Iterator[Design]:
    for shape, share, form in _PIECES:
        yield from _possible(replace(slot, angle_deg=share * slot.angle_deg), [shape], seed, form)


def _possible(
    limits: CommandLimits,
    shapes: Iterable[str],
    seed: int,
    form: Form | None = None,
) -> Iterator[Design]:
    """The designs that fit into the limits."""
    for shape in shapes:
        try:
            yield design(shape, limits, form, seed)
        except InputError:  # too short, or too few rows, for this one
            continue


def _about(made: Design, centre_deg: float) -> Design:
    rows = made.excitation
    return replace(made, excitation=Excitation(rows.time_s, centre_deg + rows.command_deg))


def _best(fishers: Array, count: int) -> int:
    return int(np.argmax([_criterion(fisher, count) for fisher in fishers]))


def _criterion(fisher: Array, count: int) -> float:
    """log det of the information about the first ``count`` with the others unknown."""
    whole, others = np.linalg.slogdet(fisher), np.linalg.slogdet(fisher[count:, count:])
    if whole.sign <= 0 or others.sign <= 0:
        return -np.inf
    return float(whole.logabsdet - others.logabsdet)


def _check(actuator: Actuator, wanted: Sequence[str]) -> None:
    known = [name for name in actuator.parameters if name != "bias"]
    for name in wanted:
        if name not in known:
            raise InputError(
                f"--for {name}: the model has no such parameter, expected some of "
                f"{', '.join(known)}; name one of these"
            )
        if actuator.value(name) == 0.0:
            raise InputError(
                f"--for {name}: the model has {name} = 0, expected a value to design for; set a "
                f"likely one in the model's card"
            )
    if not wanted:
        raise InputError(f"--for: no parameter named, expected some of {', '.join(known)}")
