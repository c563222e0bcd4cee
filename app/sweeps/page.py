"""The page of a sweep: one HTML file that needs no other file, to explore in a browser."""

from __future__ import annotations

import json
from importlib.resources import files
from pathlib import Path

from servosight.models.core import MARK, plain, write_text
from servosight.scenarios.sweeps import Summary


def write_page(found: Summary, path: Path) -> None:
    """Write the page, completely or not at all."""
    write_text(path, page(found))


def page(found: Summary) -> str:
    """The page: the summary as JSON within the script that draws it.

    Whatever a sweep's texts hold, they are shown as text: the JSON cannot end its element, and
    the script makes no HTML of it.
    """
    values = {
        **plain(found),
        "headline": found.headline,
        "failures": found.failures,
        "sentences": [answer.sentence for answer in found.found],
    }
    data = json.dumps(values, ensure_ascii=False, allow_nan=False)
    data = data.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
    template = files("servosight.app.sweeps").joinpath("page.html").read_text(encoding="utf-8")
    return template.replace("@MARK@", MARK).replace("@DATA@", data)
