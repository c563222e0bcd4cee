"""A change in words: what, by how much, how surely, and what it can mean."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from servosight.diagnose.residuals import phrased
from servosight.models.core import Estimate, chance, rounded, spoken, uncertain
from servosight.models.effects import Effect

LEAST_SIGMAS_SHOWN = 100.0
"""Beyond, the number says nothing more."""

CORE_MEANINGS = {
    ("k", "grew"): "k: the linkage, a sensor's scale or the calibration has changed",
    ("k", "fell"): "k: the linkage, a sensor's scale or the calibration has changed",
    ("k", "changed"): "k: the direction of motion has changed, of the linkage or of a sensor",
    ("T", "grew"): "T: more inertia, a lower loop gain, or a lower supply voltage",
    ("T", "fell"): "T: less inertia, a higher loop gain, or a higher supply voltage",
    ("xi", "grew"): "xi: more viscous friction (cold or thick grease), or a lower loop gain",
    ("xi", "fell"): "xi: less viscous friction (warm or lost grease), or a higher loop gain",
}
"""What a changed parameter of the core can mean: T^2 is inertia over stiffness, 2 xi T damping."""


def direction(before: float | None, after: float | None) -> str:
    """``grew``, ``fell`` or, across zero, ``changed``."""
    if before is None or after is None or before * after < 0.0:
        return "changed"
    return "grew" if abs(after) > abs(before) else "fell"


def sentence(
    name: str,
    unit: str,
    sides: tuple[Estimate | None, Estimate | None],
    sigmas: float | None,
    changed: bool,
    bound: float | None,
    alike: bool = True,
) -> str:
    """One parameter's change in words; ``bound``: what the change is below with confidence.

    ``alike``: False where the models hold different effects.
    """
    one, other = sides
    shown = "" if unit == "-" else f" {unit}"
    if one is None or other is None:
        found, side = (other, "b") if one is None else (one, "a")
        assert found is not None
        value = uncertain(found.value, found.sigma)[0]
        return f"{name} is in the model of {side} alone: {value}{shown}"
    before, after = (uncertain(side.value, side.sigma)[0] for side in (one, other))
    if changed and sigmas is not None:
        verb = direction(one.value, other.value)
        return f"{name} {verb} from {before} to {after}{shown} ({_sigmas(sigmas)})"
    if not alike:
        return f"{name} cannot be compared: {before} and {after}{shown}, beside different effects"
    if bound == 0.0:
        return f"{name} is held at {one.value:g}{shown} in both"
    if sigmas is None or bound is None:
        return f"{name} cannot be compared: {before} and {after}{shown}, of unknown sigma"
    return f"{name} is unchanged within {rounded(bound, 2)}{shown}"


def meaning(
    name: str, before: float | None, after: float | None, catalogue: Mapping[str, Effect]
) -> str:
    """What a change of a parameter can mean."""
    effect = name.partition(".")[0]
    if effect in catalogue and "." in name:
        return f"{spoken(effect)}: {catalogue[effect].cause}"
    return CORE_MEANINGS[name, direction(before, after)]


def summary_words(
    changed: Sequence[str],
    same: Sequence[str],
    unknown: Sequence[str],
    p: float | None,
    differ: bool,
    together: bool,
) -> tuple[str, str]:
    """Headline, and one sentence or two.

    ``unknown``: parameters whose sigma is not known on either side; ``differ``: a servo is
    predicted far worse by the other's model; ``together``: ``p`` is too small for chance.
    """
    unchanged = [f"unchanged: {', '.join(same)}"] if same else []
    worse = "with the other's model the error is far larger than with the own"
    if changed:
        open_ = [cannot_tell(unknown)] if unknown else []
        return changed[0], f"{'; '.join([*changed, *unchanged, *open_])}."
    if unknown and differ:
        why = f"{worse}, so they differ in this or in something that the model lacks"
        return _capital(cannot_tell(unknown)), _capital(f"{'; '.join([why, *unchanged])}.")
    headline = "No difference was found"
    if together:
        headline, unchanged = "They differ, but no parameter by itself does so surely", []
    headline += f"; {cannot_tell(unknown)}" if unknown else ""
    sure = [] if p is None else [f"a difference as large comes by chance with {chance(p)}"]
    none = [] if same else ["no parameter can be compared"]
    far = f"{worse}, which these sigmas allow: compare runs of one command that determines all"
    alike = [far] if differ and not together else []
    return headline, _capital(f"{'; '.join([*none, *unchanged, *sure, *alike])}.")


def cannot_tell(names: Sequence[str]) -> str:
    """Which parameters are not compared for want of a sigma.

    >>> cannot_tell(["T"])
    'these data cannot tell whether T differs'
    >>> cannot_tell(["k", "T", "xi"])
    'these data cannot tell whether k, T and xi differ'
    """
    listed = " and ".join(filter(None, (", ".join(names[:-1]), names[-1])))
    return f"these data cannot tell whether {listed} differ{'s' if len(names) == 1 else ''}"


def mixed_words(a: Sequence[str], b: Sequence[str]) -> tuple[str, str]:
    """Headline and summary where the models hold different effects."""
    only = [
        f"{side} alone has {phrased([one for one in own if one not in other])}"
        for side, own, other in (("a", a, b), ("b", b, a))
        if set(own) - set(other)
    ]
    return (
        f"The models hold different effects: {'; '.join(only)}",
        "What both have stands for different things in them and cannot be compared.",
    )


def different_effects(a: Sequence[str], b: Sequence[str]) -> str:
    """Why parameters are not compared, and how to do it right."""
    both = ",".join(dict.fromkeys((*a, *b)))
    return (
        f"an effect that a model lacks is not one of size 0, and a parameter that both have is not "
        f"comparable beside different effects: fit the effects of both to the recordings of each, "
        f"servosight compare REC_A REC_B --effects {both}"
    )


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def _sigmas(sigmas: float) -> str:
    size = abs(sigmas)
    return "over 100 sigma" if size > LEAST_SIGMAS_SHOWN else f"{rounded(size, 2)} sigma"
