"""A partial answer: how much is explained, what kind of thing is left, and what to do next."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from servosight.diagnose.evidence._next_steps import RECORD_AGAIN, step_for
from servosight.diagnose.evidence._repeats import Repeated
from servosight.diagnose.evidence._spread import Spread
from servosight.diagnose.residuals import (
    Finding,
    Judged,
    Window,
    listed,
    rms,
    shares,
    worst_windows,
)
from servosight.models.core import Frozen, degrees, rounded, times

KINDS = {
    "angle": "angle",
    "linkage": "angle",
    "speed": "speed",
    "motion": "speed",
    "direction": "speed",
    "acceleration": "acceleration",
    "reversal": "history",
    "standstill": "history",
    "amplitude": "amplitude",
    "time": "time",
    "frequency": "frequency",
    "command": "frequency",
    "disturbance": "disturbance",
    "stop": "stop",
}
"""What an error depends on, for each test that shows it."""
WORDS = {
    "angle": "the angle",
    "speed": "the speed or its direction",
    "acceleration": "the acceleration",
    "history": "the history (reversals, rests)",
    "amplitude": "the size of the motion",
    "time": "the time since the start",
    "frequency": "the frequency",
    "load": "the load",
    "gain": "the gain of the loop",
    "disturbance": "the known disturbance",
    "stop": "an end of the motion, as a mechanical stop",
}
DURING = {
    "reversal": ("at reversals", "history"),
    "standstill": ("at standstill", "history"),
    "slew": ("in fast motion", "speed"),
    "step": ("after steps of the command", "acceleration"),
    "high_frequency": ("in fast oscillation", "frequency"),
}
"""Each kind of motion in words, and what an error there most often depends on."""
MOST = 0.5
"""From this share of the remaining squared error on, a kind of motion holds most of it."""
LEAST = 0.1
"""A kind of motion with less is not named."""
APART = 1.5
"""Recordings at different loads or gains differ where their rms errors do by this factor."""
REPEATS = 0.5
"""From this share on, what is left is said to repeat."""
FEW = 0.01
"""Below this share, the per cent that are left have a digit behind the point."""


@dataclass(frozen=True, kw_only=True)
class Unexplained(Frozen):
    """What the last model leaves.

    ``share`` of the first model's squared error on test data is left above the floor.
    ``depends_on`` names what that depends on, most of it first: angle, speed, acceleration,
    history, amplitude, time, frequency, load, gain, disturbance, stop. ``repeats``: whether most
    of it repeats where the command does, None where no command was repeated. ``during`` is the
    share of the remaining
    squared error in each kind of motion, the largest first, and ``worst`` the stretch of time that
    holds most of it. ``next_step``: what to record next. ``spread_deg`` is the rms change of the
    prediction of the test data where the parameters move within their covariance, and ``by_chance``
    True where that is as much as the error, which then is no sign of an effect that is missing.
    ``clocks``: True where the recordings lagged one another, and those of the test, whose own
    latency is not looked for, may as well.
    """

    share: float
    depends_on: tuple[str, ...]
    repeats: bool | None
    during: Mapping[str, float]
    worst: Window | None
    sentence: str
    next_step: str | None
    spread_deg: float = 0.0
    by_chance: bool = False
    clocks: bool = False


def partial(
    errors_deg: tuple[float, float],
    floor_deg: float,
    remaining: Sequence[Finding],
    judged: Sequence[Judged],
    repeats: Repeated | None,
    spread: Spread | None = None,
) -> Unexplained:
    """What is left, from the rms errors of the first and the last model on test data.

    ``spread`` is by how much chance moves the last one's prediction, ``remaining`` are the
    findings on its error, on the recordings ``judged``.
    """
    first, last = errors_deg
    share = max(last**2 - floor_deg**2, 0.0) / max(first**2, 1e-300)
    kinds = _kinds(remaining, judged)
    again = None if repeats is None else repeats.share >= REPEATS
    during = shares(judged)
    worst = next(iter(worst_windows(judged, 1)), None)
    parts = [_left(share, first, last)]
    spread = spread or Spread()
    chance = spread.words(last)
    if chance is not None:
        parts.append(chance)
    if kinds:
        parts.append(f"it depends on {listed([WORDS[kind] for kind in kinds])}")
    else:
        parts.append("no test shows what it depends on")
    if again is not None:
        parts.append("it repeats with the command" if again else "most of it does not repeat")
    if worst is not None:
        parts.append(_place(during, worst))
    likely = kinds or tuple(DURING[one][1] for one, part in during.items() if part >= MOST)
    by_kind = step_for(likely[0], [one.recording for one in judged]) if likely else None
    return Unexplained(
        share=share,
        depends_on=kinds,
        repeats=again,
        during=during,
        worst=worst,
        sentence=f"{'; '.join(parts)}.",
        next_step=by_kind if chance is None else RECORD_AGAIN,
        spread_deg=spread.test_deg,
        by_chance=chance is not None,
    )


def _left(share: float, first_deg: float, last_deg: float) -> str:
    """How much of the first model's error is left, in words; a share of more than 1 is none."""
    if share <= 1.0:
        left = f"{100.0 * share:.0f}" if share >= FEW else rounded(100.0 * share, 1)
        return f"{left} % of the first model's squared error remains above the floor"
    return (
        f"On test data the rms error, {degrees(last_deg)}, is {times(last_deg / first_deg)} times "
        f"the first model's: these data hardly contain the motion that the effects were chosen on"
    )


def _place(during: Mapping[str, float], worst: Window) -> str:
    """In which motion and when the error remains."""
    parts = [
        f"{100.0 * part:.0f} % {place}{DURING[kind][0]}"
        for place, (kind, part) in zip(("of it is ", ""), during.items(), strict=False)
        if part >= LEAST
    ]
    return (
        f"{listed(parts)}, counted over all samples; the worst part is from "
        f"{worst.start_s:.2f} to {worst.end_s:.2f} s in the recording {worst.recording} "
        f"({degrees(worst.rmse_deg)} rms)"
    )


def taken(errors_deg: Sequence[float]) -> tuple[float, ...]:
    """Share of the first squared error that each step of a ladder takes; negative where it adds.

    >>> taken([1.0, 0.5, 0.1])
    (0.0, 0.75, 0.24)
    """
    squares = [error**2 for error in errors_deg]
    whole = max(squares[0], 1e-300)
    return (0.0, *(round((a - b) / whole, 12) for a, b in itertools.pairwise(squares)))


def _kinds(remaining: Sequence[Finding], judged: Sequence[Judged]) -> tuple[str, ...]:
    """What the error depends on, by the largest share of it that a test shows; a stop first, as the
    data beside it are those of another servo."""
    shares: dict[str, float] = {}
    for finding in remaining:
        kind = KINDS.get(finding.test)
        if kind is not None:
            shares[kind] = max(shares.get(kind, 0.0), finding.share)
    found = sorted(shares, key=lambda kind: (kind != "stop", -shares[kind]))
    conditions = [
        kind
        for kind, name in (("load", "relative_load"), ("gain", "relative_gain"))
        if _apart(judged, name)
    ]
    return (*conditions, *found)


def _apart(judged: Sequence[Judged], name: str) -> bool:
    """True where recordings at different values of an attribute have different errors."""
    values = np.array([getattr(one.recording, name) for one in judged])
    errors = [
        rms([one.error_deg for one, value in zip(judged, values, strict=True) if value == each])
        for each in np.unique(values)
    ]
    return len(errors) > 1 and max(errors) > APART * min(errors)
