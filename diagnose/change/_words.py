"""A change in words: what, by how much, how surely, and what it can mean."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from servosight.models.core import Estimate, chance, rounded, uncertain
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
) -> str:
    """One parameter's change in words; ``bound``: what the change is below with confidence."""
    one, other = sides
    shown = "" if unit == "-" else f" {unit}"
    if one is None or other is None:
        found, side = (other, "b") if one is None else (one, "a")
        assert found is not None
        value = uncertain(found.value, found.sigma)[0]
        sure = "" if sigmas is None else f", {_sigmas(sigmas)} from none"
        return f"{name} is in the model of {side} alone: {value}{shown}{sure}"
    before, after = (uncertain(side.value, side.sigma)[0] for side in (one, other))
    if changed and sigmas is not None:
        verb = direction(one.value, other.value)
        return f"{name} {verb} from {before} to {after}{shown} ({_sigmas(sigmas)})"
    if sigmas is None or bound is None:
        return f"{name} cannot be compared: {before} and {after}{shown}, of unknown sigma"
    return f"{name} is unchanged within {rounded(bound, 2)}{shown}"


def meaning(
    name: str, before: float | None, after: float | None, catalogue: Mapping[str, Effect]
) -> str:
    """What a change of a parameter can mean."""
    effect = name.partition(".")[0]
    if effect in catalogue and "." in name:
        return f"{effect.replace('_', ' ')}: {catalogue[effect].cause}"
    return CORE_MEANINGS[name, direction(before, after)]


def summary_words(changed: Sequence[str], same: Sequence[str], p: float | None) -> tuple[str, str]:
    """Headline, and one sentence or two."""
    unchanged = f"unchanged: {', '.join(same)}" if same else ""
    if not changed:
        headline = "No difference was found"
        sure = "" if p is None else f"; a difference as large comes by chance with {chance(p)}"
        return headline, f"{unchanged or 'no parameter can be compared'}{sure}.".capitalize()
    rest = f"; {unchanged}" if unchanged else ""
    return changed[0], f"{'; '.join(changed)}{rest}."


def _sigmas(sigmas: float) -> str:
    size = abs(sigmas)
    return "over 100 sigma" if size > LEAST_SIGMAS_SHOWN else f"{rounded(size, 2)} sigma"
