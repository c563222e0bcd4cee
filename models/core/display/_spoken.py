"""An effect's identifier as words."""

from __future__ import annotations

_NAMES = {"coulomb": "Coulomb", "stribeck": "Stribeck"}
_PHRASES = {
    "load_dependent_friction": "load-dependent friction",
    "load_dependent_stribeck": "load-dependent Stribeck friction",
}
"""Where the words of an identifier are not enough by themselves."""
_UNCOUNTED = frozenset(
    [
        "backlash",
        "cogging",
        "drag",
        "feedforward",
        "friction",
        "geometry",
        "hardening",
        "presliding",
        "quantization",
        "sag",
        "saturation",
    ]
)
"""Last words of what a servo has, and has not one of."""


def spoken(identifier: str) -> str:
    """The words of an identifier, people's names with a capital letter.

    >>> spoken("coulomb_friction"), spoken("load_dependent_stribeck")
    ('Coulomb friction', 'load-dependent Stribeck friction')
    """
    words = " ".join(_NAMES.get(word, word) for word in identifier.split("_"))
    return _PHRASES.get(identifier, words)


def with_article(identifier: str) -> str:
    """The same within a sentence: with an article where it can be counted.

    >>> with_article("dead_zone"), with_article("asymmetric_gain"), with_article("backlash")
    ('a dead zone', 'an asymmetric gain', 'backlash')
    """
    words = spoken(identifier)
    last = words.rsplit(" ", 1)[-1]
    if last in _UNCOUNTED or last.endswith("s"):
        return words
    return f"{'an' if words[0].lower() in 'aeiou' else 'a'} {words}"
