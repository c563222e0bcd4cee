"""What of the error a known disturbance of the log accounts for."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from servosight.diagnose.residuals._tests import independence, linear_share
from servosight.diagnose.residuals.findings._finding import Case, Finding, Test
from servosight.models.core import Recording, rounded


def _disturbance(case: Case) -> Iterator[Finding]:
    """How much of the error a filter of the disturbance removes, in runs that it acts in."""
    samples = [one for one in case.samples if one.judged.recording.disturbance_unit is not None]
    if not samples:
        return
    first = samples[0].judged.recording
    share = linear_share(samples, Recording.disturbance_at)
    found = independence(samples, Recording.disturbance_at)
    square = float(np.sum(np.concatenate([one.error_deg for one in samples]) ** 2))
    every = float(np.sum(np.concatenate([one.error_deg for one in case.samples]) ** 2))
    largest = max(
        float(np.max(np.abs(one.judged.recording.disturbance_at(one.time_s)))) for one in samples
    )
    yield case.finding(
        "disturbance",
        f"The known disturbance (up to {rounded(largest)} {first.disturbance_unit}) can account "
        f"for {100 * share:.0f} % of the squared error where it acts: a filter of it alone removes "
        f"so much.",
        share * square / max(every, 1e-300),
        found.p,
    )


TESTS: tuple[Test, ...] = (_disturbance,)
