"""The verdict in words: one place for terminal, report and JSON."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from servosight.diagnose.discrepancy import Law
from servosight.diagnose.evidence import (
    Evidence,
    Repeated,
    Stability,
    Unexplained,
)
from servosight.diagnose.residuals import EXPLAINED, listed, phrased
from servosight.diagnose.result._diagnosis import Candidate, LadderStep, Verdict
from servosight.diagnose.result._law_words import law_words
from servosight.diagnose.result._stability_words import (
    contained_words,
    equivalent_words,
    motionless_words,
    stability_words,
    uncertain_words,
    undetermined_words,
    unmeasured_words,
)
from servosight.identify.foreign import LINEAR
from servosight.models.core import degrees, times

FAR_BELOW = 0.5
"""An error below this share of the floor is far below it."""
HELPS = 0.05
"""A candidate that lowers the error by less is not worth a word."""
_TRIED = "something remains that no known effect accounts for"
_UNTRIED = "something remains that no set of known effects that was tried accounts for"
_NOTHING = Evidence(regimes=(), repeated=None, unexplained=None, detectable=())


@dataclass(frozen=True, kw_only=True)
class Levels:
    """The noise of the measurement, the tolerance, and both together: the floor [deg].

    ``scatter_deg`` is by how much runs with the same command differ. Where that is more than the
    noise, it stands in its place.
    """

    noise_deg: float
    tolerance_deg: float
    floor_deg: float
    scatter_deg: float = 0.0

    def words(self, error_deg: float) -> str:
        """How an error compares with noise, tolerance and floor; the floor is explained."""
        tolerance, noise = degrees(self.tolerance_deg), degrees(self.noise_deg)
        own, what, source = self.noise_deg, f"noise {noise}", "noise of the measurement"
        if self.scatter_deg > self.noise_deg:
            own, source = self.scatter_deg, "scatter of the servo from run to run"
            what = f"scatter from run to run {degrees(own)}"
        both = f"{what} and tolerance {tolerance} together"
        floor = f"the floor of {degrees(self.floor_deg)} ({both})"
        if error_deg > EXPLAINED * self.floor_deg:
            return f"{times(error_deg / max(self.floor_deg, 1e-12))} times {floor}"
        if self.tolerance_deg <= own and error_deg <= EXPLAINED * own:
            return f"no more than the {source}, {degrees(own)}, accounts for"
        if error_deg > max(self.tolerance_deg, own):
            return f"at {floor}"
        below = "far below" if error_deg < FAR_BELOW * self.floor_deg else "within"
        below += f" the tolerance of {tolerance} at which the search ends"
        return f"{below}; the noise of the measurement is {noise}"


def named_model(effects: Sequence[str], base: str = LINEAR) -> str:
    """A model by its effects; without any, by what they would act on.

    >>> named_model([]), named_model(["dead_zone"]), named_model([], "FMU")
    ('linear model', 'model with a dead zone', 'FMU model')
    """
    return f"model with {phrased(effects)}" if effects else f"{base} model"


def headline_and_summary(
    verdict: Verdict,
    ladder: Sequence[LadderStep],
    candidates: Sequence[Candidate],
    law: Law | None,
    levels: Levels,
    known: Evidence,
    stable: Stability,
    untried: Sequence[str] = (),
) -> tuple[str, str]:
    """Headline and summary, a line for each part of it.

    The verdict; what each step took of the error; what is left; how stable the names are; which
    models err as little. ``untried`` effects were ruled out beforehand: what is said of known
    effects leaves them open.
    """
    certain = stable.named(ladder[-1].effects)
    headline, summary = verdict_words(verdict, ladder, candidates, law, levels, known, stable.named)
    lines = [
        summary,
        known.too_weak or "",
        *partial_words(ladder, known.unexplained, known.repeated),
        stability_words(certain, stable.shares, stable.resamples),
        contained_words(stable.contained),
        undetermined_words(stable.undetermined),
        motionless_words(stable.motionless),
        unmeasured_words([name for name in stable.unmeasured if name in certain]),
        equivalent_words(ladder[-1].effects, stable.equivalents, stable.one_of, stable.closer),
    ]
    if untried and verdict is Verdict.UNEXPLAINED:
        lines.append(f"Not tried, as ruled out beforehand: {listed(untried)}.")
    words = "\n".join(filter(None, lines))
    return headline + uncertain_words(ladder, stable.uncertain), words


def verdict_words(
    verdict: Verdict,
    ladder: Sequence[LadderStep],
    candidates: Sequence[Candidate],
    law: Law | None,
    levels: Levels,
    known: Evidence = _NOTHING,
    named: Callable[[Sequence[str]], Sequence[str]] = tuple,
) -> tuple[str, str]:
    """Headline, and one sentence or two.

    A regime beyond the fitted data that holds most of the error comes first. On its account, or
    where the error is accounted for, nothing is said to be missing from the catalogue; where the
    search was cut short, only from what it tried. Of the effects that were added those are called
    missing that ``named`` makes of them.
    """
    first, last = ladder[0].held_out_rmse_deg, ladder[-1].held_out_rmse_deg
    effects, base = ladder[-1].effects, named_model(ladder[0].effects, ladder[0].base)
    added = [name for name in effects if name not in ladder[0].effects]
    gone = [name for name in ladder[0].effects if name not in effects]
    if verdict is not Verdict.UNEXPLAINED and not (added or gone):
        return (
            "No further effect is missing" if effects else "No effect is missing",
            f"The {base} predicts the test data to {degrees(last)} rms, {levels.words(last)}.",
        )
    verb = "falls" if last <= first else "rises"
    fell = f"its rms error on test data {verb} from {degrees(first)} to {degrees(last)}"
    if verdict is not Verdict.UNEXPLAINED and not added:
        return (
            f"Not needed: {listed(gone)}",
            f"The {base} of this servo does not need {phrased(gone)}: without it, the rms error on "
            f"test data is {degrees(last)}, {levels.words(last)}.",
        )
    if verdict is not Verdict.UNEXPLAINED:
        return (
            _missing(named(added)),
            f"The {base} of this servo {_wrong(named(added), gone)}. With "
            f"{phrased(effects) or 'none'} in the model, {fell}, {levels.words(last)}.",
        )
    if known.leading is not None:
        error = f"Over all test data the rms error of the {base} is {degrees(first)}"
        error = f"With {phrased(added)} added to the {base}, {fell}" if added else error
        return (
            "The error is outside the fitted data",
            f"{known.leading.words} {error}, {levels.words(last)}.",
        )
    remains = _UNTRIED if known.cut_short else _TRIED
    if law is not None:
        return law_words(law, effects, remains)
    if added:
        missed = _missed(ladder[-1], levels, "still ")
        return (
            "Not fully explained",
            f"With {phrased(added)} added to the {base}, {fell}, {missed}"
            + ("." if known.accounted else f": {remains}."),
        )
    error = f"The rms error of the {base} on test data is {degrees(first)}, "
    error += f"{_missed(ladder[0], levels)}; {_best_single(candidates, first)}."
    return f"The {base} misses something", error


def _missed(step: LadderStep, levels: Levels, still: str = "") -> str:
    """How the errors of a step miss the floor: that of the test, else that of the validation."""
    tested, chosen = step.held_out_rmse_deg, step.validation_rmse_deg
    if tested > EXPLAINED * levels.floor_deg:
        return f"{still}{levels.words(tested)}"
    return (
        f"{levels.words(tested)}; but on validation data it is {degrees(chosen)}, "
        f"{levels.words(chosen)}"
    )


def _best_single(candidates: Sequence[Candidate], error_deg: float) -> str:
    """The effect with the most evidence, and why it is not accepted, or that none helps."""
    best = candidates[0] if candidates else None
    if best is not None and best.held_out_rmse_deg <= (1.0 - HELPS) * error_deg:
        return (
            f"of the known effects, {phrased([best.effect])} alone has the most evidence and "
            f"lowers it to {degrees(best.held_out_rmse_deg)}{_driven(best.at_bounds)}"
        )
    return "no single known effect accounts for it"


def _driven(at_bounds: Sequence[str]) -> str:
    """Why a candidate is not accepted that drives something to a bound.

    >>> _driven(["T"])
    ', but is not accepted: with it T rests on a bound of its range, a value that no servo has'
    >>> _driven([])
    ''
    """
    if not at_bounds:
        return ""
    rest = (
        "rests on a bound of its range, a value"
        if len(at_bounds) == 1
        else "rest on bounds of their ranges, values"
    )
    return f", but is not accepted: with it {listed(at_bounds)} {rest} that no servo has"


def _missing(certain: Sequence[str]) -> str:
    """The headline of a model that explains the recordings, with the effects named for certain."""
    return f"What was missing: {listed(certain)}" if certain else "Something was missing"


def _wrong(certain: Sequence[str], gone: Sequence[str]) -> str:
    """What a first model lacks for certain, and what it has and does not need.

    >>> _wrong(["dead_zone"], ["cogging"]), _wrong([], [])
    ('lacks a dead zone and does not need cogging', 'lacks something')
    """
    lacks = [f"lacks {phrased(certain) or 'something'}"] if certain or not gone else []
    return " and ".join([*lacks, *([f"does not need {phrased(gone)}"] if gone else [])])


def partial_words(
    ladder: Sequence[LadderStep], left: Unexplained | None, again: Repeated | None
) -> list[str]:
    """Lines: what each step took of the squared error, what is left, how much of it repeats."""
    if left is None:
        return []
    steps = [_change_words(step) for step in ladder[1:]]
    of = "Squared error on test data, as a share of the first model's"
    took = [f"{of}: {'; '.join(steps)}."] if steps else []
    return [*took, left.sentence, *([] if again is None else [again.sentence])]


def _change_words(step: LadderStep) -> str:
    """What a step did to the squared error: ``backlash added, -12 %``."""
    done = [(step.added, "added"), (step.removed, "removed")]
    change = " and ".join(f"{listed([name])} {verb}" for name, verb in done if name)
    return f"{change}, {_signed_percent(-step.taken)}"


def _signed_percent(share: float) -> str:
    """A share in per cent with its sign, if it is not 0 once it is rounded.

    >>> _signed_percent(-0.59), _signed_percent(0.03), _signed_percent(-0.004)
    ('-59 %', '+3 %', '0 %')
    """
    percent = round(100.0 * share)
    return f"{percent:+d} %" if percent else "0 %"


def comparison_words(error_deg: float, explained: bool, levels: Levels) -> tuple[str, str]:
    """Headline and one sentence for a given model on recordings."""
    return (
        "The model holds" if explained else "The model misses something",
        f"On these recordings the rms error of the model is {degrees(error_deg)}, "
        f"{levels.words(error_deg)}.",
    )


def alternative_words(effects: Sequence[str], alternatives: Sequence[Sequence[str]]) -> str:
    """That other models predict the same as the one with ``effects``, and what follows.

    >>> alternative_words(["dead_time"], [["flexible_shaft"], ["backlash", "cogging"]])[:87]
    'These recordings cannot distinguish a dead time from a flexible shaft; or from backlash'
    """
    others = "; or from ".join(phrased(other) for other in alternatives)
    return (
        f"These recordings cannot distinguish {phrased(effects)} from {others}: their predictions "
        f"differ by less than the noise. Do not rely on the name until another experiment has "
        f"decided."
    )
