"""Recordings made ready for a diagnosis: what is used of them, and how small an error counts."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from servosight.diagnose.evidence import Scatter, run_floor
from servosight.diagnose.result.wording import Levels
from servosight.diagnose.selection import (
    AcceptanceCriterion,
    PriorKnowledge,
    SelectionPolicy,
    Spans,
    cut,
    stretches,
)
from servosight.identify.fit import floor_deg, tolerance_deg
from servosight.identify.problem import (
    joint_noise_deg,
    offered,
    thinned,
    usable_views,
)
from servosight.models.core import InputError, Recording, is_same_run, refuse_repeats
from servosight.models.effects import Effect

USES = "fit", "validate", "test"
"""What recordings are for, in the order in which they are given."""


@dataclass(frozen=True, kw_only=True)
class DiagnosisData:
    """Recordings in order, fitted ones first, and what of them is used.

    ``whole`` are the recordings, ``spans`` the stretches [s] of each that are used, none where it
    is used whole; ``fitted``, ``validate`` and ``test`` are those stretches, with the samples that
    are scored. ``runs`` numbers the recording that each stretch to fit or to validate is of.
    ``catalogue`` holds the effects that these recordings can show. ``scatter`` is by how
    much runs with the same command differ, None where that says nothing. ``left_out`` and
    ``shortened`` are warnings on samples that are not used: faulty ones, and those of long
    recordings.
    """

    whole: tuple[Recording, ...]
    spans: tuple[Spans, ...]
    fitted: tuple[Recording, ...]
    validate: tuple[Recording, ...]
    test: tuple[Recording, ...]
    runs: tuple[int, ...]
    catalogue: Mapping[str, Effect]
    levels: Levels
    scatter: Scatter | None
    left_out: tuple[str, ...]
    shortened: tuple[str, ...]

    def criterion(self, policy: SelectionPolicy) -> AcceptanceCriterion:
        """What a model must meet on these recordings; a scatter as floor is known from few runs."""
        levels, scatter = self.levels, self.scatter
        accepted = AcceptanceCriterion(levels.floor_deg, levels.tolerance_deg, policy)
        if scatter is None or scatter.rms_deg <= levels.noise_deg:
            return accepted
        # The tolerance is known exactly (Satterthwaite, Biometrics Bulletin 2 (1946) 110).
        freedom = scatter.freedom * (levels.floor_deg / scatter.rms_deg) ** 4
        return replace(accepted, worth=scatter.worth, freedom=freedom)


def diagnosis_data(
    groups: tuple[Sequence[Recording], Sequence[Recording], Sequence[Recording]],
    catalogue: Mapping[str, Effect],
    prior: PriorKnowledge,
    *,
    tolerance: float | None,
    most_rows: int,
) -> DiagnosisData:
    """What a diagnosis uses of recordings to fit, to validate and to test, in this order.

    ``tolerance`` [deg] is what no model need be right within (None: 0.05 % of the moved range);
    recordings with more than ``most_rows`` rows are cut to stretches. Raises InputError where a
    required effect cannot show in the fitted recordings, and where one recording has two uses.
    """
    _refuse_two_uses(groups)
    usable, left_out = zip(*map(usable_views, groups), strict=True)
    whole = tuple(itertools.chain(*usable))
    known = offered(catalogue, usable[0], prior.first)
    levels, scatter, repeats = _levels(whole, tolerance)
    spans, notes = stretches(whole, most_rows)
    parts = [cut(recording, own) for recording, own in zip(whole, spans, strict=True)]
    scored, thinning = thinned([part for own in parts for part in own])
    counts = iter(map(len, parts))
    fitted, validate, test = (
        sum(itertools.islice(counts, len(recordings))) for recordings in usable
    )
    runs = [run for run, own in enumerate(parts) for _ in own]
    return DiagnosisData(
        whole=whole,
        spans=tuple(spans),
        fitted=tuple(scored[:fitted]),
        validate=tuple(scored[fitted : fitted + validate]),
        test=tuple(scored[len(scored) - test :]),
        runs=tuple(runs[: fitted + validate]),
        catalogue=known,
        levels=levels,
        scatter=scatter,
        left_out=(*itertools.chain(*left_out), *repeats),
        shortened=(*notes, *thinning),
    )


def _refuse_two_uses(groups: Sequence[Sequence[Recording]]) -> None:
    """InputError where a recording has two uses, or one use twice."""
    for group in groups:
        refuse_repeats(group)
    used = [(use, one) for use, group in zip(USES, groups, strict=True) for one in group]
    for (first, one), (second, other) in itertools.combinations(used, 2):
        if first != second and is_same_run(one, other):
            raise InputError(
                f"{other.name}: the same recording is given to {first} and to {second}, expected "
                f"one use of each; give another run to {second}, or none: parts of the recordings "
                f"then {second}"
            )


def _levels(
    recordings: tuple[Recording, ...], tolerance: float | None
) -> tuple[Levels, Scatter | None, list[str]]:
    """Noise, tolerance and floor; the scatter of equal runs, and what there is to say of it."""
    noise = joint_noise_deg(recordings)
    tolerance = tolerance_deg(recordings, tolerance)
    scatter, repeats = run_floor(recordings)
    scatter_deg = scatter.rms_deg if scatter else 0.0
    floor = floor_deg(recordings, max(noise, scatter_deg), tolerance)
    levels = Levels(
        noise_deg=noise, tolerance_deg=tolerance, floor_deg=floor, scatter_deg=scatter_deg
    )
    return levels, scatter, repeats
