"""What the tests of an error show, as plain sentences: those that matter, the largest first.

A finding must be more than chance (1 in 100, also where errors are autocorrelated) and large
enough to matter beside the floor, which noise alone is not. Every size is the rms of that part of
the error which the sentence describes, so that sizes compare; parts overlap, so shares do not add
up.
"""

from __future__ import annotations

from collections.abc import Sequence

from servosight.diagnose.residuals._judged import EXPLAINED, Judged
from servosight.diagnose.residuals.findings import _disturbance as disturbance_findings
from servosight.diagnose.residuals.findings import _motion as motion_findings
from servosight.diagnose.residuals.findings import _side as side_findings
from servosight.diagnose.residuals.findings import _stops as stop_findings
from servosight.diagnose.residuals.findings import _system as system_findings
from servosight.diagnose.residuals.findings._finding import Case, Finding, shown
from servosight.models.core import times

TESTS = (
    *side_findings.TESTS,
    *disturbance_findings.TESTS,
    *stop_findings.TESTS,
    *motion_findings.TESTS,
    *system_findings.TESTS,
)
CHANCE = 0.01
MATTERS = 0.5
"""A part of the error counts from this share of the floor on, as an rms."""
LEAST_SHARE = 0.05
"""And from this share of the squared error on."""
GENERAL = ("linearity", "whiteness")
"""Tests that do not say where an error comes from: they come last."""


def findings(judged: Sequence[Judged], floor_deg: float, noise_deg: float) -> tuple[Finding, ...]:
    """What the tests find in the error of a model, largest first; empty where they find nothing.

    Whiteness and independence are tested on the test samples, and on those of the validation too
    where they are too few; what the error depends on, with all samples of these recordings.
    Recordings that were only fitted do not count beside others.
    """
    case = Case.of(judged, floor_deg, noise_deg)
    if not case.held_out or case.rms_deg <= MATTERS * floor_deg:
        return ()
    found = [
        one
        for test in TESTS
        for one in test(case)
        if one.p < CHANCE and one.size_deg >= MATTERS * floor_deg and one.share >= LEAST_SHARE
    ]
    return tuple(sorted(found, key=lambda one: (one.test in GENERAL, -one.size_deg)))


def lead(judged: Sequence[Judged], found: Sequence[Finding], floor_deg: float) -> str:
    """One sentence on the error as a whole, before the findings."""
    rms = Case.of(judged, floor_deg, floor_deg).rms_deg
    if not found and rms <= EXPLAINED * floor_deg:
        return (
            f"The error ({shown(rms, 3)} deg rms) is no larger than the floor: no test finds a "
            f"systematic error."
        )
    if not found:
        return (
            f"The error ({shown(rms, 3)} deg rms) is above the floor of {shown(floor_deg, 3)} "
            f"deg, but no test shows what it depends on."
        )
    floors = times(rms / max(floor_deg, 1e-12))
    return f"Over all samples the error is {shown(rms, 3)} deg rms, {floors} times the floor."
