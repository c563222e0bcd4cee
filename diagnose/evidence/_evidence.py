"""All evidence on the last model of a ladder, gathered in one value."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from servosight.diagnose.evidence._inclusion import include
from servosight.diagnose.evidence._regimes import Regime, regimes
from servosight.diagnose.residuals import Judged
from servosight.diagnose.selection import ModelSelection, Trial


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What the last model's error says of the data: ``regimes``, the leading ones first."""

    regimes: tuple[Regime, ...]

    @property
    def leading(self) -> Regime | None:
        """The regime that holds most of the error, None where none does."""
        return next((one for one in self.regimes if one.leading), None)


def gather(
    models: ModelSelection, last: Trial, judged: Sequence[Judged], floor_deg: float
) -> Evidence:
    """The evidence on ``last``, whose recordings with its predictions are ``judged``."""
    found = regimes(judged, floor_deg)
    return Evidence(regimes=_with_inclusion(models, last, judged, found))


def _with_inclusion(
    models: ModelSelection, last: Trial, judged: Sequence[Judged], found: tuple[Regime, ...]
) -> tuple[Regime, ...]:
    """The first regime, where it leads, with what fitting its recording too gives.

    Only where none of the recording is fitted.
    """
    if not found or not found[0].leading:
        return found
    apart = [one.recording for one in judged if not one.fitted.any()]
    for recording in apart:
        if recording.name == found[0].recording:
            return (replace(found[0], inclusion=include(models, last, recording)), *found[1:])
    return found
