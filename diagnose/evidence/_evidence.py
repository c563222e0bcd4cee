"""All evidence on the last model of a ladder, in one value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from servosight.diagnose.evidence._detectable import detectable
from servosight.diagnose.evidence._partial import Unexplained, partial
from servosight.diagnose.evidence._repeats import Repeated, repeated
from servosight.diagnose.evidence._spread import spread_of
from servosight.diagnose.evidence._too_weak import too_weak
from servosight.diagnose.evidence.regimes import WITHOUT_IT, Regime, include, regimes
from servosight.diagnose.residuals import Finding, Judged, held_out_rms, held_out_samples_of
from servosight.diagnose.selection import AcceptanceCriterion, ModelSelection, Trial
from servosight.identify.fit import Detectable


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What the last model's error says of the data: ``regimes``, the leading ones first.

    ``repeated``: how much of it repeats, None where no command does; ``unexplained``: what is left
    of it, None where nothing is; ``detectable``: from which size on each other one would show;
    ``too_weak``: a sentence on an effect with which nothing is left and that is not accepted;
    ``cut_short``: the search ended because of its cost, with sets of effects untried.
    """

    regimes: tuple[Regime, ...]
    repeated: Repeated | None
    unexplained: Unexplained | None
    detectable: tuple[Detectable, ...]
    too_weak: str | None = None
    cut_short: bool = False

    @property
    def leading(self) -> Regime | None:
        """The regime that holds most of the error, None where none does."""
        return next((one for one in self.regimes if one.leading), None)

    @property
    def by_chance(self) -> bool:
        """True where parameters within their sigma may be all of the error."""
        return self.unexplained is not None and self.unexplained.by_chance

    @property
    def accounted(self) -> bool:
        """True where chance may be all of the error, or an effect that is too weak to be named."""
        return self.by_chance or self.too_weak is not None


def gather(
    models: ModelSelection,
    first: Trial,
    last: Trial,
    judged: Sequence[Judged],
    remaining: Sequence[Finding],
    criterion: AcceptanceCriterion,
    cut_short: bool,
) -> Evidence:
    """The evidence on ``last``: ``judged`` are its predictions, ``remaining`` findings on them.

    ``first`` is the first step's trial. It is given, as a better fit of it may have been found
    since, which no step shows.
    """
    floor_deg = criterion.floor_deg
    found = regimes(judged, floor_deg)
    again = repeated(judged)
    errors = held_out_rms(models.tested(first)), held_out_rms(judged)
    missed = not criterion.at_floor(errors[1], held_out_samples_of(judged))
    left = None
    if missed:
        left = partial(errors, floor_deg, remaining, judged, again, spread_of(models, last))
        split = models.split
        left = replace(left, clocks=bool(split.tested) and any(split.late_s))
    return Evidence(
        regimes=_with_inclusion(models, last, judged, found),
        repeated=again,
        unexplained=left,
        detectable=detectable(models, last, criterion),
        too_weak=too_weak(models, last, criterion) if missed else None,
        cut_short=cut_short,
    )


def _with_inclusion(
    models: ModelSelection, last: Trial, judged: Sequence[Judged], found: tuple[Regime, ...]
) -> tuple[Regime, ...]:
    """The first regime, where it leads, with what fitting its recording too gives.

    Only where none of the recording is fitted, and not for an input that no model has.
    """
    if not found or not found[0].leading or found[0].remedy == WITHOUT_IT:
        return found
    apart = [one.recording for one in judged if not one.fitted.any()]
    for recording in apart:
        if recording.name == found[0].recording:
            return (replace(found[0], inclusion=include(models, last, recording)), *found[1:])
    return found
