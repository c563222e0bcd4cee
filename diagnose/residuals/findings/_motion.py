"""What the error has to do with the motion: its kind, speed, direction, angle, turns and rests."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from servosight.diagnose.residuals._events import rests, swings, turns
from servosight.diagnose.residuals._profiles import Quantity, profile
from servosight.diagnose.residuals._samples import Index, grouped
from servosight.diagnose.residuals.findings._finding import Case, Finding, Test, shown, signed
from servosight.models.core import Array, rms

STRONGER = 1.5
"""Errors are called larger from this multiple of the others on."""
CROWDED = 1.25
"""A kind of motion is named from this ratio of its shares of squared error and of time on."""
MONOTONE = 0.9
"""Rank correlation of the error with time from which on it drifts."""
GROWS = (0.35, 1.4)
"""Powers of the size of the motion with which an error grows, and grows faster than the motion."""
AT_ONCE_S = 0.03
"""What is largest so soon after a turn was there when the model turned."""
ONE_WAY = 0.3
"""An error lags or leads where its mean in the direction of motion is this share of its size."""

_WORDS = {
    "reversal": "at reversals of the surface",
    "standstill": "where the surface is at rest",
    "slew": "while the surface moves steadily",
    "step": "just after steps of the command",
    "high_frequency": "where the command oscillates fast",
}


def _motion(case: Case) -> Iterator[Finding]:
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
        f"The error is largest {_WORDS[kinds[worst]]} ({100 * error[worst]:.0f} % of the "
        f"squared error in {100 * time[worst]:.0f} % of the time){speed}.",
        float(error[worst]),
        grouped(case.samples, sizes, groups).p,
    )


def _speed_words(case: Case) -> str:
    """Whether the size of the error goes with speed, as the end of a sentence."""
    speed = np.concatenate([np.abs(one.speed_deg_s[one.scored]) for one in case.samples])
    error = np.concatenate([one.error_deg[one.scored] for one in case.samples])
    slow, fast = np.quantile(speed, [0.35, 0.65])
    at_rest = rms(error[speed <= slow])
    on_way = rms(error[speed >= fast])
    if on_way > STRONGER * at_rest:
        return " and grows with speed"
    if at_rest > STRONGER * on_way:
        return " and is larger at low speed than at high speed"
    return " and does not grow with speed"


def _lag(case: Case) -> Iterator[Finding]:
    """The error in the direction of motion, slow and fast: what lags."""
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
    if max(abs(slow), abs(fast)) < ONE_WAY * case.rms_deg * np.sqrt(effect.share):
        error = np.concatenate(
            [one.error_deg[m] for one, m in zip(case.samples, moving, strict=True)]
        )
        sentence = (
            f"The mean error depends on how fast the surface moves, not on its direction: "
            f"{signed(float(np.mean(error[speed <= edges[0]])))} deg moving slowly, "
            f"{signed(float(np.mean(error[speed >= edges[1]])))} deg moving fast"
        )
    elif slow * fast > 0.0 and max(slow / fast, fast / slow) < STRONGER:
        sentence = (
            f"Moving, the surface {_behind(slow)} the model by {shown(abs(0.5 * (slow + fast)))} "
            f"deg, at any speed"
        )
    else:
        sentence = (
            f"Moving slowly, the surface {_behind(slow)} the model by {shown(abs(slow))} deg; "
            f"moving fast, it {_behind(fast)} it by {shown(abs(fast))} deg"
        )
    yield case.finding("speed", f"{sentence}.", effect.share, effect.p)


def _behind(ahead_deg: float) -> str:
    return "leads" if ahead_deg > 0.0 else "lags"


def _acceleration(case: Case) -> Iterator[Finding]:
    yield from _against(case, "acceleration", "deg/s²")


def _angle(case: Case) -> Iterator[Finding]:
    yield from _against(case, "angle", "deg")


def _against(case: Case, quantity: Quantity, unit: str) -> Iterator[Finding]:
    """The mean error against a quantity, by where it is least and most."""
    found = profile(case.samples, quantity)
    if found is None:
        return
    low, high = int(np.argmin(found.median_deg)), int(np.argmax(found.median_deg))
    # What is next to zero is called so.
    at = np.where(np.abs(found.x) < 1e-3 * np.ptp(found.x), 0.0, found.x)
    yield case.finding(
        quantity,
        f"The mean error depends on the {quantity}: {signed(found.median_deg[low])} deg near "
        f"{shown(at[low], 3)} {unit}, {signed(found.median_deg[high])} deg near "
        f"{shown(at[high], 3)} {unit}.",
        found.effect.share,
        found.effect.p,
    )


def _drift(case: Case) -> Iterator[Finding]:
    found = profile(case.samples, "time")
    if found is None or found.x.size < 4:
        return
    ranks = np.argsort(np.argsort(found.median_deg))
    if abs(np.corrcoef(ranks, np.arange(ranks.size))[0, 1]) >= MONOTONE:
        yield case.finding(
            "time",
            f"The error drifts, from {signed(found.median_deg[0])} deg to "
            f"{signed(found.median_deg[-1])} deg at the end.",
            found.effect.share,
            found.effect.p,
        )


def _direction(case: Case) -> Iterator[Finding]:
    """Whether one way is worse than the other."""
    groups = [_way(one.direction) for one in case.samples]
    sizes = [np.abs(one.error_deg) for one in case.samples]
    errors = np.concatenate([one.error_deg[one.scored] for one in case.samples])
    way = np.concatenate([g[one.scored] for one, g in zip(case.samples, groups, strict=True)])
    if min(np.sum(way == 0), np.sum(way == 1)) < 30:
        return
    square = [float(np.sum(errors[way == side] ** 2)) for side in (0, 1)]
    size_deg = [np.sqrt(square[side] / np.sum(way == side)) for side in (0, 1)]
    worse = int(size_deg[1] > size_deg[0])
    if size_deg[worse] < STRONGER * size_deg[1 - worse]:
        return
    yield case.finding(
        "direction",
        f"The error is larger while the angle {('falls', 'rises')[worse]} "
        f"({shown(size_deg[worse])} deg rms) than while it {('falls', 'rises')[1 - worse]} "
        f"({shown(size_deg[1 - worse])} deg).",
        square[worse] / max(float(np.sum(errors**2)), 1e-300),
        grouped(case.samples, sizes, groups).p,
    )


def _reversal(case: Case) -> Iterator[Finding]:
    found = turns(case.samples)
    if found is None:
        return
    late = found.lag_s >= 0.0
    after, when = found.after_deg, found.lag_s[late][np.argmax(np.abs(found.mean_deg[late]))]
    if when < AT_ONCE_S:
        side = "short of" if after > 0.0 else "beyond"
        words = (
            f"The surface reverses {shown(abs(after))} deg {side} the model's turning point (mean "
            f"of {found.count} reversals)."
        )
    else:
        words = (
            f"After a reversal the surface {_behind(after)} the model by up to {shown(abs(after))} "
            f"deg, {1000 * when:.0f} ms after the turning point (mean of {found.count})."
        )
    yield case.finding("reversal", words, found.share, found.p)


def _standstill(case: Case) -> Iterator[Finding]:
    found = rests(case.samples)
    if found is not None:
        beyond = "beyond" if found.short_deg > 0.0 else "short of"
        yield case.finding(
            "standstill",
            f"The surface comes to rest {shown(abs(found.short_deg))} deg {beyond} the model's "
            f"final angle, from either side (mean of {found.count}).",
            found.share,
            found.p,
        )


def _amplitude(case: Case) -> Iterator[Finding]:
    found = swings(case.samples, case.noise_deg)
    if found is None:
        return
    half = found.size_deg.size // 2
    square = found.samples * found.rms_deg**2
    whole = sum(float(np.sum(one.error_deg[one.scored] ** 2)) for one in case.samples)
    sizes = np.quantile(found.size_deg, [0.25, 0.75])
    about = (
        f"{shown(np.median(found.rms_deg[:half]))} deg rms at swings of about {shown(sizes[0])} "
        f"deg, {shown(np.median(found.rms_deg[half:]))} deg at {shown(sizes[1])} deg"
    )
    if found.power < GROWS[0]:
        return
    words = "faster than the motion" if found.power > GROWS[1] else "with the size of the motion"
    share = min(float(np.sum(square[half:])) / max(whole, 1e-300), 1.0)
    yield case.finding("amplitude", f"The error grows {words}: {about}.", share, found.chance(0.0))


def _numbered(kinds: NDArray[np.str_], names: Sequence[str]) -> Index:
    """The place of each kind in ``names``, -1 where it is not among them."""
    return np.array([names.index(kind) if kind in names else -1 for kind in kinds.tolist()])


def _way(direction: Array) -> Index:
    """0 while the angle falls, 1 while it rises, -1 at rest."""
    return np.asarray(np.where(direction == 0.0, -1, (direction > 0.0).astype(int)))


TESTS: tuple[Test, ...] = (
    _motion,
    _lag,
    _acceleration,
    _angle,
    _drift,
    _direction,
    _reversal,
    _standstill,
    _amplitude,
)
