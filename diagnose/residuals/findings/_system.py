"""What the error has to do with the command, with itself, and with frequency."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.special import gammaincc

from servosight.diagnose.residuals._frequency import Response, response
from servosight.diagnose.residuals._judged import Judged
from servosight.diagnose.residuals._tests import independence, linear_share, quantile, whiteness
from servosight.diagnose.residuals.findings._finding import Case, Finding, Test, shown, signed
from servosight.identify.discrete import Distortion, distortion
from servosight.models.core import InputError

MOSTLY = 0.5
"""From this share of the squared error on, what is missing may be linear."""


def _command(case: Case) -> Iterator[Finding]:
    """Ljung's test of independence, and how much a linear model of any order could remove."""
    found = independence(case.held_out)
    peak = found.peak
    share = linear_share(case.samples)
    allowed = quantile(0.99) * found.sigma[peak]
    yield case.finding(
        "command",
        f"The error is correlated with the command (coefficient {signed(found.value[peak])} at a "
        f"lag of {shown(found.lag_s[peak])} s, by chance at most {shown(allowed)}): a linear "
        f"model of higher order could remove up to {100 * share:.0f} % of the squared error.",
        max(share, float(found.value[peak]) ** 2),
        found.p,
    )
    rest = (1.0 - share) * case.rms_deg**2
    count = sum(int(one.scored.sum()) for one in case.samples)
    if share < MOSTLY:
        yield case.finding(
            "linearity",
            f"A linear model of higher order, with any delay or resonance, could remove "
            f"{_percent(share)} of the squared error: most of what is missing is not linear.",
            max(rest - case.floor_deg**2, 0.0) / max(case.rms_deg**2, 1e-300),
            float(gammaincc(0.5 * count, 0.5 * count * rest / max(case.floor_deg, 1e-12) ** 2)),
        )


def _whiteness(case: Case) -> Iterator[Finding]:
    found = whiteness(case.held_out)
    if not found.value.size:
        return
    share = float(np.clip(found.value[0], 0.0, 1.0))
    below = np.flatnonzero(found.value < 1.0 / np.e)
    lasts = found.lag_s[below[0]] if below.size else found.lag_s[-1]
    yield case.finding(
        "whiteness",
        f"The error is autocorrelated: the correlation from sample to sample is {share:.2f} and "
        f"lasts for {'about' if below.size else 'more than'} {shown(lasts)} s.",
        share,
        found.p,
    )


def _frequency(case: Case) -> Iterator[Finding]:
    """Where over frequency the answer differs from the model's."""
    found = response(case.judged)
    if found is None:
        return
    peak = int(np.argmax(found.misfit_deg2))
    where = case.on(found.recording)
    yield case.finding(
        "frequency",
        f"{where}{'near' if where else 'Near'} {shown(found.frequency_hz[peak])} Hz the servo "
        f"answers with {_gain_words(found, peak)} than the model.",
        case.share_of(found.recording, float(found.misfit_deg2.sum())),
        float(min(1.0, found.p[peak] * found.p.size)),
    )


def _gain_words(found: Response, line: int) -> str:
    ratio = found.measured[line] / found.model[line]
    gain, phase = abs(ratio) - 1.0, float(np.angle(ratio, deg=True))
    return (
        f"{shown(100 * abs(gain))} % {'more' if gain > 0 else 'less'} gain and "
        f"{shown(abs(phase))} deg {'more' if phase < 0 else 'less'} lag"
    )


def _distortion(case: Case) -> Iterator[Finding]:
    """Even and odd distortion, where the command is a multisine that shows it."""
    for one in case.judged:
        found = _distorted(one)
        if found is None:
            continue
        level = min((found.odd, found.even), key=lambda kind: kind.chance)
        levels = [kind.rms_deg for kind in (found.odd, found.even) if kind.found]
        share = case.share_of(one.recording, float(np.sum(np.square(levels))))
        words = case.on(one.recording) + found.sentence
        yield case.finding("distortion", words, share, level.chance)


def _distorted(one: Judged) -> Distortion | None:
    try:
        return distortion(one.recording)
    except InputError:  # too few periods or frames: no test
        return None


def _percent(share: float) -> str:
    return "almost nothing" if share < 0.005 else f"only {100 * share:.0f} %"


TESTS: tuple[Test, ...] = (_command, _whiteness, _frequency, _distortion)
