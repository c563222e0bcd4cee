"""What the tests of an error show, as plain sentences: those that matter, the largest first.

A finding must be more than chance (1 in 100, also where errors hang together in time) and large
enough to matter beside the floor, which noise alone is not. Every size is the rms of that part of
the error which the sentence speaks of, so that sizes compare; parts overlap, so shares do not add
up.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincc

from servosight.diagnose.events import rests, swings, turns
from servosight.diagnose.frequency import Response, response
from servosight.diagnose.profiles import profile
from servosight.diagnose.residual_tests import independence, linear_share, whiteness
from servosight.diagnose.samples import Index, Samples, grouped, samples_of
from servosight.diagnose.trial import Judged
from servosight.identify.distortion import Distortion, distortion
from servosight.models.errors import InputError

Array = NDArray[np.float64]

CHANCE = 0.01
MATTERS = 0.5
"""A part of the error counts from this share of the floor on, as an rms."""
LEAST_SHARE = 0.05
"""And from this share of the squared error on."""
STRONGER = 1.5
"""Errors are called larger where they are so many times the others."""
CROWDED = 1.25
"""A kind of motion is named where its share of the squared error is so many times that of time."""
MONOTONE = 0.9
"""Rank correlation of the error with time from which on it drifts."""

GROWS = (0.35, 1.4)
"""Powers of the size of the motion with which an error grows, and grows faster than the motion."""
MOSTLY = 0.5
AT_ONCE_S = 0.03
GENERAL = ("linearity", "whiteness")
"""Tests that say nothing of where an error comes from: they stand last."""

_WORDS = {
    "reversal": "where the surface turns round",
    "standstill": "where the surface stands still",
    "slew": "while the surface is on its way",
    "step": "just after steps of the command",
    "high_frequency": "where the command swings fast",
}


@dataclass(frozen=True)
class Finding:
    """What a test shows.

    ``size_deg`` is the rms of the part of the error that it speaks of, ``share`` that part of the
    squared error, ``p`` how often chance shows as much.
    """

    test: str
    sentence: str
    size_deg: float
    share: float
    p: float

    def to_json(self) -> dict[str, Any]:
        """As a table."""
        return asdict(self)


@dataclass(frozen=True)
class _Case:
    """The samples under test, their rms error, and what they are held to."""

    samples: tuple[Samples, ...]
    judged: tuple[Judged, ...]
    rms_deg: float
    noise_deg: float
    floor_deg: float

    def finding(self, test: str, sentence: str, share: float, p: float) -> Finding:
        """A finding on so large a share of the squared error."""
        return Finding(test, sentence, self.rms_deg * float(np.sqrt(share)), share, p)


def findings(judged: Sequence[Judged], floor_deg: float, noise_deg: float) -> tuple[Finding, ...]:
    """What stands out in the error of a model, largest first; nothing where nothing does.

    On the held-out samples, where there are any; responses over frequency on whole recordings.
    """
    samples = tuple(samples_of(judged))
    if not samples:
        return ()
    errors = np.concatenate([one.error_deg[one.scored] for one in samples])
    rms = float(np.sqrt(np.mean(errors**2)))
    case = _Case(samples, tuple(judged), rms, noise_deg, floor_deg)
    if case.rms_deg <= MATTERS * floor_deg:
        return ()
    found = [
        one
        for test in _TESTS
        for one in test(case)
        if one.p < CHANCE and one.size_deg >= MATTERS * floor_deg and one.share >= LEAST_SHARE
    ]
    return tuple(sorted(found, key=lambda one: (one.test in GENERAL, -one.size_deg)))


def lead(judged: Sequence[Judged], found: Sequence[Finding], floor_deg: float) -> str:
    """One sentence on the error as a whole, before the findings."""
    errors = [one.error_deg[one.scored] for one in samples_of(judged)]
    rms = float(np.sqrt(np.mean(np.concatenate(errors) ** 2))) if errors else 0.0
    if not found and rms <= 1.1 * floor_deg:
        return f"The error ({rms:.3g} deg rms) is no larger than the floor: nothing stands out."
    if not found:
        return (
            f"The error ({rms:.3g} deg rms) is above the floor of {floor_deg:.3g} deg, but no test "
            f"shows what it depends on."
        )
    return f"The error is {rms:.3g} deg rms, {rms / max(floor_deg, 1e-12):.2g} times the floor."


def _motion(case: _Case) -> Iterator[Finding]:
    """In which kind of motion the error is."""
    kinds = sorted({str(kind) for one in case.samples for kind in np.unique(one.kinds[one.scored])})
    groups = [_numbered(one.kinds, kinds) for one in case.samples]
    sizes = [np.abs(one.error_deg) for one in case.samples]
    joined = np.concatenate([g[one.scored] for one, g in zip(case.samples, groups, strict=True)])
    square = np.concatenate(
        [s[one.scored] ** 2 for one, s in zip(case.samples, sizes, strict=True)]
    )
    time = np.bincount(joined, minlength=len(kinds)) / joined.size
    error = np.bincount(joined, square, len(kinds)) / max(float(square.sum()), 1e-300)
    worst = int(np.argmax(error - time))
    if len(kinds) < 2 or error[worst] < CROWDED * time[worst]:
        return
    speed = _speed_words(case)
    yield case.finding(
        "motion",
        f"The error is largest {_WORDS[kinds[worst]]} ({100 * error[worst]:.0f} % of its square "
        f"in {100 * time[worst]:.0f} % of the time){speed}.",
        float(error[worst]),
        grouped(case.samples, sizes, groups).p,
    )


def _speed_words(case: _Case) -> str:
    """Whether the size of the error goes with speed, as the end of a sentence."""
    speed = np.concatenate([np.abs(one.speed_deg_s[one.scored]) for one in case.samples])
    error = np.concatenate([one.error_deg[one.scored] for one in case.samples])
    slow, fast = np.quantile(speed, [0.35, 0.65])
    at_rest = np.sqrt(np.mean(error[speed <= slow] ** 2))
    on_way = np.sqrt(np.mean(error[speed >= fast] ** 2))
    if on_way > STRONGER * at_rest:
        return " and grows with speed"
    if at_rest > STRONGER * on_way:
        return " and is larger at low speed than at high speed"
    return " and does not grow with speed"


def _lag(case: _Case) -> Iterator[Finding]:
    """The error in the direction of motion, slow and fast: what trails."""
    speeds = [np.abs(one.speed_deg_s) for one in case.samples]
    moving = [one.scored & (one.direction != 0.0) for one in case.samples]
    speed = np.concatenate([v[m] for v, m in zip(speeds, moving, strict=True)])
    if speed.size < 60:
        return
    edges = np.quantile(speed, [1 / 3, 2 / 3])
    pace = [np.searchsorted(edges, one) for one in speeds]
    ways = [_way(one.direction) for one in case.samples]
    groups = [np.where(w < 0, -1, 3 * w + v) for w, v in zip(ways, pace, strict=True)]
    effect = grouped(case.samples, [one.error_deg for one in case.samples], groups)
    ahead = np.concatenate(
        [(one.direction * one.error_deg)[m] for one, m in zip(case.samples, moving, strict=True)]
    )
    slow = float(np.mean(ahead[speed <= edges[0]]))
    fast = float(np.mean(ahead[speed >= edges[1]]))
    if slow * fast > 0.0 and max(slow / fast, fast / slow) < STRONGER:
        sentence = (
            f"Moving, the surface {_behind(slow)} the model by {abs(0.5 * (slow + fast)):.2g} deg, "
            f"at any speed"
        )
    else:
        sentence = (
            f"Moving slowly, the surface {_behind(slow)} the model by {abs(slow):.2g} deg; moving "
            f"fast, it {_behind(fast)} it by {abs(fast):.2g} deg"
        )
    yield case.finding("speed", f"{sentence}.", effect.share, effect.p)


def _behind(ahead_deg: float) -> str:
    return "leads" if ahead_deg > 0.0 else "trails"


def _acceleration(case: _Case) -> Iterator[Finding]:
    found = profile(case.samples, "acceleration")
    if found is not None:
        yield case.finding(
            "acceleration",
            f"The mean error goes with acceleration: {_signed(found.median_deg[0])} deg at "
            f"{found.x[0]:.3g} deg/s², {_signed(found.median_deg[-1])} deg at {found.x[-1]:.3g}.",
            found.effect.share,
            found.effect.p,
        )


def _angle(case: _Case) -> Iterator[Finding]:
    found = profile(case.samples, "angle")
    if found is None:
        return
    low, high = int(np.argmin(found.median_deg)), int(np.argmax(found.median_deg))
    yield case.finding(
        "angle",
        f"The mean error depends on the angle: {_signed(found.median_deg[low])} deg near "
        f"{found.x[low]:.3g} deg, {_signed(found.median_deg[high])} deg near {found.x[high]:.3g}.",
        found.effect.share,
        found.effect.p,
    )


def _drift(case: _Case) -> Iterator[Finding]:
    found = profile(case.samples, "time")
    if found is None or found.x.size < 4:
        return
    ranks = np.argsort(np.argsort(found.median_deg))
    if abs(np.corrcoef(ranks, np.arange(ranks.size))[0, 1]) >= MONOTONE:
        yield case.finding(
            "time",
            f"The error drifts, from {_signed(found.median_deg[0])} deg to "
            f"{_signed(found.median_deg[-1])} deg at the end.",
            found.effect.share,
            found.effect.p,
        )


def _direction(case: _Case) -> Iterator[Finding]:
    """Whether one way is worse than the other."""
    groups = [_way(one.direction) for one in case.samples]
    sizes = [np.abs(one.error_deg) for one in case.samples]
    errors = np.concatenate([one.error_deg[one.scored] for one in case.samples])
    way = np.concatenate([g[one.scored] for one, g in zip(case.samples, groups, strict=True)])
    if min(np.sum(way == 0), np.sum(way == 1)) < 30:
        return
    square = [float(np.sum(errors[way == side] ** 2)) for side in (0, 1)]
    rms = [np.sqrt(square[side] / np.sum(way == side)) for side in (0, 1)]
    worse = int(rms[1] > rms[0])
    if rms[worse] < STRONGER * rms[1 - worse]:
        return
    yield case.finding(
        "direction",
        f"The error is larger while the angle {('falls', 'rises')[worse]} ({rms[worse]:.2g} deg "
        f"rms) than while it {('falls', 'rises')[1 - worse]} ({rms[1 - worse]:.2g} deg).",
        square[worse] / max(float(np.sum(errors**2)), 1e-300),
        grouped(case.samples, sizes, groups).p,
    )


def _reversal(case: _Case) -> Iterator[Finding]:
    found = turns(case.samples)
    if found is None:
        return
    late = found.lag_s >= 0.0
    after, when = found.after_deg, found.lag_s[late][np.argmax(np.abs(found.mean_deg[late]))]
    if when < AT_ONCE_S:
        side = "short of" if after > 0.0 else "beyond"
        words = (
            f"The surface turns round {abs(after):.2g} deg {side} where the model does (mean of "
            f"{found.count} reversals)."
        )
    else:
        words = (
            f"After a reversal the surface {'hangs back' if after < 0.0 else 'runs ahead'} by up "
            f"to {abs(after):.2g} deg, {1000 * when:.0f} ms after the turn (mean of {found.count})."
        )
    yield case.finding("reversal", words, found.share, found.p)


def _standstill(case: _Case) -> Iterator[Finding]:
    found = rests(case.samples)
    if found is not None:
        beyond = "beyond" if found.short_deg > 0.0 else "short of"
        yield case.finding(
            "standstill",
            f"The surface comes to rest {abs(found.short_deg):.2g} deg {beyond} where the model "
            f"does, from whichever side it comes (mean of {found.count}).",
            found.share,
            found.p,
        )


def _amplitude(case: _Case) -> Iterator[Finding]:
    found = swings(case.samples, case.noise_deg)
    if found is None:
        return
    half = found.size_deg.size // 2
    square = found.samples * found.rms_deg**2
    whole = sum(float(np.sum(one.error_deg[one.scored] ** 2)) for one in case.samples)
    sizes = np.quantile(found.size_deg, [0.25, 0.75])
    about = (
        f"{np.median(found.rms_deg[:half]):.2g} deg rms at swings of about {sizes[0]:.2g} deg, "
        f"{np.median(found.rms_deg[half:]):.2g} deg at {sizes[1]:.2g} deg"
    )
    if found.power < GROWS[0]:
        return
    words = "faster than the motion" if found.power > GROWS[1] else "with the size of the motion"
    share = min(float(np.sum(square[half:])) / max(whole, 1e-300), 1.0)
    yield case.finding("amplitude", f"The error grows {words}: {about}.", share, found.chance(0.0))


def _command(case: _Case) -> Iterator[Finding]:
    """Ljung's test of independence, and how much a linear model of any order could take."""
    found = independence(case.samples)
    peak = found.peak
    share = linear_share(case.samples)
    yield case.finding(
        "command",
        f"The error follows the command (correlation {_signed(found.value[peak])} after "
        f"{found.lag_s[peak]:.2g} s, where chance allows {2.58 * found.sigma[peak]:.2g}), so that "
        f"a freer linear model, with a delay or a resonance, could take {100 * share:.0f} % of its "
        f"square.",
        max(share, float(found.value[peak]) ** 2),
        found.p,
    )
    rest = (1.0 - share) * case.rms_deg**2
    count = sum(int(one.scored.sum()) for one in case.samples)
    if share < MOSTLY:
        yield case.finding(
            "linearity",
            f"A freer linear model, with any delay or resonance, could take {_percent(share)} of "
            f"the squared error: most of what is missing is not linear.",
            max(rest - case.floor_deg**2, 0.0) / max(case.rms_deg**2, 1e-300),
            float(gammaincc(0.5 * count, 0.5 * count * rest / max(case.floor_deg, 1e-12) ** 2)),
        )


def _whiteness(case: _Case) -> Iterator[Finding]:
    found = whiteness(case.samples)
    if not found.value.size:
        return
    share = float(np.clip(found.value[0], 0.0, 1.0))
    below = np.flatnonzero(found.value < 1.0 / np.e)
    lasts = found.lag_s[below[0]] if below.size else found.lag_s[-1]
    yield case.finding(
        "whiteness",
        f"The error is not white: {100 * share:.0f} % of its square carries over from sample to "
        f"sample, for {'about' if below.size else 'more than'} {lasts:.2g} s.",
        share,
        found.p,
    )


def _frequency(case: _Case) -> Iterator[Finding]:
    """Where over frequency the answer differs from the model's."""
    found = response(case.judged)
    if found is None:
        return
    peak = int(np.argmax(found.misfit_deg2))
    square = float(found.misfit_deg2.sum())
    share = float(np.clip(square / max(case.rms_deg**2, 1e-300), 0.0, 1.0))
    yield case.finding(
        "frequency",
        f"Near {found.frequency_hz[peak]:.2g} Hz the servo answers with {_gain_words(found, peak)} "
        f"than the model.",
        share,
        float(min(1.0, found.p[peak] * found.p.size)),
    )


def _gain_words(found: Response, line: int) -> str:
    ratio = found.measured[line] / found.model[line]
    gain, phase = abs(ratio) - 1.0, float(np.angle(ratio, deg=True))
    return (
        f"{100 * abs(gain):.2g} % {'more' if gain > 0 else 'less'} gain and {abs(phase):.2g} deg "
        f"{'more' if phase < 0 else 'less'} lag"
    )


def _distortion(case: _Case) -> Iterator[Finding]:
    """Even and odd distortion, where the command is a multisine that shows it."""
    for one in case.judged:
        found = _distorted(one)
        if found is None:
            continue
        level = min((found.odd, found.even), key=lambda kind: kind.chance)
        levels = [kind.rms_deg for kind in (found.odd, found.even) if kind.found]
        size = float(np.sqrt(np.sum(np.square(levels))))
        share = float(np.clip((size / max(case.rms_deg, 1e-300)) ** 2, 0.0, 1.0))
        yield Finding("distortion", found.sentence, size, share, level.chance)


def _distorted(one: Judged) -> Distortion | None:
    try:
        return distortion(one.recording)
    except InputError:  # too few periods or frames: no test
        return None


_TESTS: tuple[Callable[[_Case], Iterator[Finding]], ...] = (
    _motion,
    _lag,
    _acceleration,
    _angle,
    _drift,
    _direction,
    _reversal,
    _standstill,
    _amplitude,
    _command,
    _whiteness,
    _frequency,
    _distortion,
)


def _numbered(kinds: NDArray[np.str_], names: Sequence[str]) -> Index:
    """The place of each kind in ``names``, -1 where it is not among them."""
    return np.array([names.index(kind) if kind in names else -1 for kind in kinds.tolist()])


def _way(direction: Array) -> Index:
    """0 while the angle falls, 1 while it rises, -1 at rest."""
    return np.asarray(np.where(direction == 0.0, -1, (direction > 0.0).astype(int)))


def _percent(share: float) -> str:
    return "next to nothing" if share < 0.005 else f"only {100 * share:.0f} %"


def _signed(value: float) -> str:
    return f"{value:+.2g}"
