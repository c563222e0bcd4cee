"""The page of a sweep: one HTML file that needs no other file, to explore in a browser."""

from __future__ import annotations

import json
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

from servosight.app.sweeps.axes import joint_axes
from servosight.models.core import MARK, plain, write_text
from servosight.scenarios.sweeps import Summary

MOST_ROWS = 20_000
"""Settings that a page holds; more make a page that browsers are slow with."""


def write_page(found: Summary, path: Path) -> None:
    """Write the page, completely or not at all."""
    write_text(path, page(found))


def page(found: Summary) -> str:
    """The page: the summary as JSON within the script that draws it.

    Whatever a sweep's texts hold, they are shown as text: the JSON cannot end its element, and
    the script makes no HTML of it.
    """
    step = -(-len(found.table) // MOST_ROWS) or 1
    shown = replace(found, table=found.table[::step])
    values = {
        **plain(shown),
        "joint": [list(axis.names) for axis in joint_axes(shown)],
        "headline": found.headline + (f"; one setting in {step} is shown" if step > 1 else ""),
        "failures": found.failures,
        "sentences": [answer.sentence for answer in found.found],
    }
    data = json.dumps(values, ensure_ascii=False, allow_nan=False)
    data = data.replace("<", "\\u003c").replace("\u2028", "\\u2028").replace("\u2029", "\\u2029")
    template = files("servosight.app.sweeps").joinpath("page.html").read_text(encoding="utf-8")
    return template.replace("@MARK@", MARK).replace("@DATA@", data)
