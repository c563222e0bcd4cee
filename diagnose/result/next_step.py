"""What to do next, in one sentence: one place for terminal, report and JSON."""

from __future__ import annotations

from servosight.diagnose.evidence import RECORD_AGAIN, Regime, Unexplained
from servosight.diagnose.experiment import Proposal
from servosight.diagnose.result._diagnosis import Verdict

NOTHING_MISSING = "Nothing is missing here; to look further, use a larger and faster command."
AT_FLOOR = "The model reached the floor: confirm it on a recording with another command."
TRY_PAIRS = "No single effect improves the model enough: use --auto, which tries pairs."
CLOCKS = (
    "Settle the clocks first: the recordings lag one another, and of the test recordings the "
    "latency is not known; log command and angle by one clock, or give latency_s in each "
    "recording.toml."
)
REPEAT = (
    "Something remains unexplained: repeat the recording to see what repeats, at half and at "
    "double the amplitude to see what scales, and more slowly to see what depends on speed."
)


def next_experiment(
    verdict: Verdict,
    proposal: Proposal | None,
    candidate: str | None,
    auto: bool,
    regime: Regime | None = None,
    left: Unexplained | None = None,
    card: bool = True,
) -> str:
    """What to do next; ``candidate``: the best effect, where it is accepted alone.

    ``regime`` is one beyond the fitted data that holds most of the error, ``left`` what the last
    model leaves. Where that is not explained, what may be no effect at all comes first: the regime,
    then the clocks, then chance; then models to distinguish, and the kind of what remains. ``card``
    says whether a model card can hold the model.
    """
    if verdict is Verdict.NO_EFFECT_MISSING:
        return NOTHING_MISSING
    open_ = verdict is Verdict.UNEXPLAINED
    if open_ and regime is not None:
        return regime.remedy
    if open_ and left is not None and left.clocks:
        return CLOCKS
    if open_ and left is not None and left.by_chance:
        return RECORD_AGAIN
    if proposal is not None and (proposal.recommended or not (open_ and auto)):
        return proposal.sentence
    if verdict is Verdict.EXPLAINED:
        return AT_FLOOR
    if auto:
        return REPEAT if left is None or left.next_step is None else left.next_step
    if candidate is None:
        return TRY_PAIRS
    if not card:
        return f"Add {candidate}: use --auto."
    return f"Add {candidate}: `servosight add MODEL.toml {candidate} REC`, or use --auto."
