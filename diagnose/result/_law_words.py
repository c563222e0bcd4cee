"""A law of what the ladder leaves, in words."""

from __future__ import annotations

from collections.abc import Sequence

from servosight.diagnose.discrepancy import Law
from servosight.diagnose.residuals import phrased
from servosight.models.core import degrees


def law_words(law: Law, effects: Sequence[str], remains: str) -> tuple[str, str]:
    """Headline, and what was found beside the ``effects`` of the last model.

    A search that ends early may leave what an effect of the catalogue would account for; where none
    has an equation like the law's, ``remains`` says what is left.
    """
    closed = f"{100.0 * min(law.closed, 1.0):.0f} %"
    named = f" with {phrased(effects)}" if effects else ""
    terms = ", and ".join(term.words for term in law.terms)
    gone = (
        f"the error of the model{named} on test data falls from {degrees(law.held_out_before_deg)} "
        f"to {degrees(law.held_out_after_deg)}, which closes {closed} of the gap to the floor of "
        f"{degrees(law.floor_deg)}."
    )
    if law.known:
        return (
            f"Not fully explained; {phrased(law.known)} would close {closed} of the gap",
            f"Something remains that the search did not find: a torque that {terms}, as of "
            f"{phrased(law.known)}. With it {gone}",
        )
    left = (
        "Not fully explained by known effects" if effects else "Not explained by any known effect"
    )
    return (
        f"{left}; a law closes {closed} of the gap",
        f"{remains[0].upper()}{remains[1:]}: a torque that {terms}. With this law {gone}",
    )
