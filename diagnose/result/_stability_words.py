"""How firmly effects are named, in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from servosight.diagnose.evidence.stability import LEAST
from servosight.diagnose.residuals import listed, phrased
from servosight.diagnose.result._diagnosis import LadderStep

MOST_MODELS = 4
"""Number of other models that are listed."""


def stability_words(effects: Sequence[str], shares: Mapping[str, float], resamples: int) -> str:
    """How often effects are named when parts of the data are left out; empty where not tried.

    >>> stability_words(["backlash"], {"backlash": 1.0, "cogging": 0.3}, 10)
    'Of 10 parts of the data, 10 name backlash. Not called missing: cogging (3 of 10).'
    >>> stability_words([], {"backlash": 0.8}, 10)
    'Not called missing, though at least half of the parts name it: backlash (8 of 10).'
    """
    if not shares:
        return ""
    firm = [f"{_count(shares[n], resamples)} name {listed([n])}" for n in effects if n in shares]
    others = {name: share for name, share in shares.items() if name not in effects}
    rare = [name for name, share in others.items() if share < LEAST]
    open_ = [name for name in others if name not in rare]
    it = "it" if len(open_) == 1 else "them"
    counted = {
        name: f"{listed([name])} ({_count(share, resamples)} of {resamples})"
        for name, share in others.items()
    }
    lines = [
        (f"Of {resamples} parts of the data, ", firm),
        ("Not called missing: ", [counted[name] for name in rare]),
        (
            f"Not called missing, though at least half of the parts name {it}: ",
            [counted[name] for name in open_],
        ),
    ]
    return " ".join(f"{begin}{', '.join(names)}." for begin, names in lines if names)


def contained_words(contained: Mapping[str, str]) -> str:
    """Why special cases are called missing and not the effects of the model that contain them.

    >>> contained_words({"stribeck_friction": "coulomb_friction"})[:62]
    'Of Stribeck friction only Coulomb friction is called missing: '
    """
    if not contained:
        return ""
    pairs = [f"of {phrased([name])} only {phrased([one])}" for name, one in contained.items()]
    are = "is called missing" if len(pairs) == 1 else "are called missing"
    return (
        f"O{', '.join(pairs)[1:]} {are}: what the model has beyond that lowers the error, but is "
        f"uncertain."
    )


def undetermined_words(effects: Sequence[str]) -> str:
    """Why effects of the model are not called missing, though the error falls with them.

    >>> undetermined_words(["linkage_geometry"])[:55]
    'The data do not determine linkage geometry: none of its'
    """
    if not effects:
        return ""
    which = "its" if len(effects) == 1 else "their"
    return (
        f"The data do not determine {phrased(effects)}: none of {which} parameters differs from "
        f"its neutral value by more than its sigma, so that another run may name something else."
    )


def motionless_words(effects: Sequence[str]) -> str:
    """Why effects of a model whose T is not known are not called missing.

    >>> motionless_words(["torque_saturation"])[:42]
    'T is known to no better than its own size,'
    """
    if not effects:
        return ""
    return (
        f"T is known to no better than its own size, so the data show no motion of the servo's own "
        f"by which {phrased(effects)} could be distinguished from what else is left of the torque: "
        f"record faster motion as well."
    )


def unmeasured_words(effects: Sequence[str]) -> str:
    """Why effects are called missing of which no sigma is known.

    >>> unmeasured_words(["dead_time"])[:41]
    'No sigma is known of any size of dead tim'
    """
    if not effects:
        return ""
    it, stays = ("it", "it stays") if len(effects) == 1 else ("them", "they stay")
    return (
        f"No sigma is known of any size of {listed(effects)} (the warnings say why): its size is "
        f"open, and {stays} named because the error falls with {it}."
    )


def equivalent_words(
    effects: Sequence[str],
    others: Sequence[Sequence[str]],
    one_of: Mapping[str, Sequence[str]],
    closer: bool = False,
) -> str:
    """Which other models do as well, what all have in common, and what stands in for the rest.

    ``closer``: they err clearly less than the model of the ``effects``, which is enough within the
    tolerance.

    >>> equivalent_words(["backlash"], [], {})
    ''
    >>> others = [["gravity_load", "backlash"]]
    >>> words = equivalent_words(
    ...     ["gravity_load", "coulomb_friction"], others, {"coulomb_friction": ["backlash"]})
    >>> words.endswith("All have a gravity load, and one of Coulomb friction and backlash.")
    True
    >>> equivalent_words(["backlash"], [["dead_zone"]], {"backlash": ["dead_zone"]}, True)[:46]
    'The one with a dead zone errs clearly less, bu'
    """
    if not others:
        return ""
    models = "; ".join(f"with {phrased(other)}" for other in others[:MOST_MODELS])
    more = len(others) - MOST_MODELS
    models += f"; or {more} more" if more > 0 else ""
    common = [name for name in effects if name not in one_of]
    groups = [f"one of {phrased([name, *instead])}" for name, instead in one_of.items() if instead]
    shared = ", and ".join([*([phrased(common)] if common else []), *groups])
    why = (
        f"These data cannot tell the model from the one {models}: the errors differ by no more "
        f"than they scatter from second to second, so another run may name another."
    )
    if closer:
        why = (
            f"The one {models} errs clearly less, but within the tolerance the model with fewer or "
            f"likelier effects is enough: a smaller tolerance decides between them (--tolerance)."
        )
    return f"{why} " + (f"All have {shared}." if shared else "No effect is in all of them.")


def uncertain_words(ladder: Sequence[LadderStep], uncertain: Sequence[str]) -> str:
    """What the headline adds for effects that were chosen and are too seldom named."""
    chosen = [name for name in uncertain if any(name in step.effects for step in ladder)]
    return f"; uncertain: {listed(chosen)}" if chosen else ""


def _count(share: float, resamples: int) -> int:
    return round(share * resamples)
