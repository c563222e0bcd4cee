"""Regimes: where validation and test data go beyond the fitted ones, and how much error is there.

A model may fail on a recording because something is missing in it, or because the recording moves
the servo as the fitted data never did.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from servosight.diagnose.evidence.regimes._inclusion import Inclusion
from servosight.diagnose.motion import MARGIN, RATIO, FittedRange, MeasuredMotion, fitted_ranges
from servosight.diagnose.residuals import EXPLAINED, TEST, VALIDATION, Judged, rms
from servosight.models.core import Array, Mask, rounded


@dataclass(frozen=True, kw_only=True)
class RegimePolicy:
    """Thresholds of what counts as beyond the fitted data, and as the reason of an error.

    ``margin`` and ``ratio`` are those of :func:`fitted_ranges`.
    A regime is listed from ``least_samples`` on, as a share of the samples of that use, and from
    ``fewest`` samples on. It leads where the error misses the floor, ``leading`` of the squared
    error is there, and the rms there is ``worse`` times that of all data within the fitted range.
    From ``whole`` of the samples on it does not say where in the recording the model fails: such a
    regime comes first only where no other leads.
    """

    margin: float = MARGIN
    ratio: float = RATIO
    least_samples: float = 0.01
    fewest: int = 10
    leading: float = 0.5
    worse: float = 1.5
    whole: float = 0.95


@dataclass(frozen=True, kw_only=True)
class Regime:
    """Where a recording goes beyond the fitted data in one quantity.

    ``fitted_low`` and ``fitted_high`` are the extremes of the fitted samples, ``beyond`` is "above"
    or "below" and ``limit`` the value from which a sample counts, ``reached`` the largest (or
    smallest) value. ``share_samples`` of the recording's samples of that ``use`` (test or
    validation) lie there, and ``share_error`` of their squared error by the last model, with
    ``rmse_deg``. ``leading``: most of the error is there, and the model fails there above all.
    ``remedy`` is the next step; ``inclusion`` says what fitting the recording too gives, where that
    was tried.
    """

    quantity: str
    unit: str
    fitted_low: float
    fitted_high: float
    beyond: str
    limit: float
    reached: float
    share_samples: float
    share_error: float
    rmse_deg: float
    recording: str
    use: str
    leading: bool
    sentence: str
    remedy: str
    inclusion: Inclusion | None = None

    @property
    def words(self) -> str:
        """The sentence, and what fitting the recording too gives."""
        more = "" if self.inclusion is None else f" {self.inclusion.sentence}"
        return f"{self.sentence}.{more}"


WITHOUT_IT = (
    "Fit a run with the known disturbance as well, which the effect known_disturbance takes as an "
    "input, or test on a run without it."
)


def regimes(
    judged: Sequence[Judged], floor_deg: float, policy: RegimePolicy | None = None
) -> tuple[Regime, ...]:
    """Where the held-out samples of ``judged`` go beyond the fitted ones, leading ones first.

    Of these, those in which a part of the samples lies beyond; and the more, the further the share
    of the error there exceeds that of the samples. Empty where nothing is fitted or nothing is held
    out.
    """
    policy = policy or RegimePolicy()
    motions = [MeasuredMotion(one.recording) for one in judged]
    fitted = [one.fitted for one in judged]
    found = []
    for known in fitted_ranges(motions, fitted, policy.margin, policy.ratio):
        beyond = known.beyond
        usual = rms([one.error_deg[~mask] for one, mask in zip(judged, beyond, strict=True)])
        case = _Case(known, usual, floor_deg, policy)
        for one, value, mask in zip(judged, known.values, beyond, strict=True):
            found += list(case.rows(one, value, mask))
    order = {"test": 0, "validation": 1}
    return tuple(
        sorted(
            found,
            key=lambda one: (
                not one.leading,
                one.share_samples >= policy.whole,
                order[one.use],
                one.share_samples - one.share_error,
            ),
        )
    )


@dataclass(frozen=True)
class _Case:
    """One side of one quantity: what was fitted, and the rms error of all data within it."""

    known: FittedRange
    usual_deg: float
    floor_deg: float
    policy: RegimePolicy

    def rows(self, one: Judged, values: Array, beyond: Mask) -> Iterator[Regime]:
        """A row for each use of the recording's samples that goes beyond."""
        for use, name in ((TEST, "test"), (VALIDATION, "validation")):
            mask = one.uses == use
            there = mask & beyond
            count = int(there.sum())
            if count < max(self.policy.fewest, self.policy.least_samples * int(mask.sum())):
                continue
            yield self._row(one, values, mask, there, name)

    def _row(self, one: Judged, values: Array, mask: Mask, there: Mask, use: str) -> Regime:
        square = one.error_deg**2
        share = float(square[there].sum() / max(float(square[mask].sum()), 1e-300))
        rmse = rms([one.error_deg[there]])
        missed = rms([one.error_deg[mask]]) > EXPLAINED * self.floor_deg
        reached = float(values[there].max() if self.known.side == "above" else values[there].min())
        leads = missed and share >= self.policy.leading
        leads = leads and rmse >= self.policy.worse * self.usual_deg
        return Regime(
            quantity=self.known.quantity.name,
            unit=self.known.quantity.unit or one.recording.disturbance_unit or "",
            fitted_low=self.known.low,
            fitted_high=self.known.high,
            beyond=self.known.side,
            limit=self.known.limit,
            reached=reached,
            share_samples=float(there.sum() / mask.sum()),
            share_error=share,
            rmse_deg=rmse,
            recording=one.recording.name,
            use=use,
            leading=leads,
            sentence=self._words(one, float(there.sum() / mask.sum()), share, reached),
            remedy=WITHOUT_IT if self.known.quantity.kind == "input" else _remedy(one),
        )

    def _words(self, one: Judged, samples: float, share: float, reached: float) -> str:
        """How much error lies beyond, what was fitted, and the way out."""
        name, unit = self.known.quantity.name, self.known.quantity.unit
        end = self.known.high if self.known.side == "above" else self.known.low
        word = "up to" if self.known.side == "above" else "down to"
        if self.known.quantity.kind == "factor":
            where = f"{_with_article(name)} of {rounded(reached)}"
            held = "only" if self.known.low == self.known.high else f"and {word} that only"
            fitted = f"the fitted data have {rounded(end)} {held}"
        else:
            unit = unit or one.recording.disturbance_unit or ""
            where = f"{_with_article(name)} {self.known.side} {rounded(self.known.limit)} {unit}"
            fitted = f"the fitted data reach {rounded(end)} {unit}"
        way_out = "fit this recording too" if not one.fitted.any() else "record longer"
        if self.known.quantity.kind == "input":
            way_out = "fit a run with it as well, or test on a run without it"
        what = f"{100.0 * share:.0f} % of the squared error on {one.recording.name} lies"
        if samples >= self.policy.whole:
            what = f"{100.0 * samples:.0f} % of the samples of {one.recording.name} lie"
        return f"{what} at {where}; {fitted}: {way_out}"


def _remedy(one: Judged) -> str:
    """The next step, as a sentence."""
    name = one.recording.name
    if one.fitted.any():
        return (
            f"Record {name} for longer, or again: its fitted part contains no motion like "
            f"that on which the model fails."
        )
    return (
        f"Name {name} among the fitted recordings, and test on another run: its motion "
        f"goes beyond the fitted data."
    )


def _with_article(name: str) -> str:
    return f"{'an' if name[0] in 'aeiou' else 'a'} {name}"
