"""Pieces of text that several exports write."""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib import resources

from servosight.export.core._contract import ExportRequest
from servosight.models.core import MARK, Kind


def number(value: float) -> str:
    """The shortest decimal that reads back as the same double, with a point or an exponent.

    >>> number(2.0), number(0.1), number(1e-30)
    ('2.0', '0.1', '1e-30')
    """
    return repr(float(value))


def mark_of(kind: str) -> str:
    """The mark by which an export is known as the program's own; it goes into a comment.

    >>> mark_of("control")
    'Written by servosight: export (control)'
    """
    return f"{MARK}: {Kind.EXPORT.value} ({kind})"


def provenance_lines(request: ExportRequest) -> list[str]:
    """The model in words: parameters with sigma and unit, effects, one line each."""
    actuator = request.actuator
    lines = [
        f"{name} = {number(one.value)}"
        + ("" if one.sigma is None else f" +- {one.sigma:.2g}")
        + (f" {one.unit}" if one.unit not in ("", "-") else "")
        for name, one in actuator.parameters.items()
    ]
    return [*lines, f"effects: {', '.join(actuator.effects) or 'none'}"]


def filled(package: str, template: str, words: Mapping[str, str]) -> str:
    """The text of a template of ``servosight.export.PACKAGE``, each ``@word@`` replaced."""
    folder = resources.files(f"servosight.export.{package}") / "templates"
    text = (folder / template).read_text(encoding="utf-8")
    return re.sub(r"@(\w+)@", lambda found: words[found[1]], text)
