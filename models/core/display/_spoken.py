"""An effect's identifier as words."""

from __future__ import annotations

_NAMES = {"coulomb": "Coulomb", "stribeck": "Stribeck"}


def spoken(identifier: str) -> str:
    """The words of an identifier, people's names with a capital letter.

    >>> spoken("coulomb_friction")
    'Coulomb friction'
    """
    return " ".join(_NAMES.get(word, word) for word in identifier.split("_"))
