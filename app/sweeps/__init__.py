"""What a sweep found, drawn: a picture, or a page that needs no other file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from servosight.models.base import InputError, Kind

if TYPE_CHECKING:
    from servosight.scenarios.sweeps import Summary

_KINDS = {".png": Kind.PNG, ".html": Kind.HTML, ".htm": Kind.HTML}


def plot_kind(path: Path) -> Kind:
    """What is drawn to ``path``, by its ending; InputError for another ending."""
    if path.suffix.lower() not in _KINDS:
        raise InputError(
            f"{path}: has the ending {path.suffix!r}, expected .png or .html; choose one of them"
        )
    return _KINDS[path.suffix.lower()]


def draw(found: Summary, path: Path) -> None:
    """Write the picture or the page, completely or not at all."""
    if plot_kind(path) is Kind.PNG:
        from servosight.app.sweeps.picture import write_picture

        write_picture(found, path)
    else:
        from servosight.app.sweeps.page import write_page

        write_page(found, path)
