"""From a story to a page of HTML: sections in order, each with a template of its name."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime
from importlib.resources import files

import jinja2
from markupsafe import Markup

from servosight import __version__
from servosight.app.report.section import Section
from servosight.app.report.sections.error.law import section as law
from servosight.app.report.sections.error.regimes import section as regimes
from servosight.app.report.sections.error.residuals import section as residuals
from servosight.app.report.sections.error.where import section as where
from servosight.app.report.sections.model.dynamics import section as dynamics
from servosight.app.report.sections.model.parameters import section as parameters
from servosight.app.report.sections.model.response import section as response
from servosight.app.report.sections.recording.angle import section as angle
from servosight.app.report.sections.recording.film import section as film
from servosight.app.report.sections.recording.picture import section as picture
from servosight.app.report.sections.selection.candidates import section as candidates
from servosight.app.report.sections.selection.experiment import section as experiment
from servosight.app.report.sections.selection.ladder import section as ladder
from servosight.app.report.sections.selection.method import section as method
from servosight.app.report.sections.selection.verdict import section as verdict
from servosight.app.report.story import Story, sentence
from servosight.models.core import chance, degrees, rounded, signed, spoken, uncertain

SECTIONS: tuple[Callable[[Story], Section | None], ...] = (
    verdict,
    ladder,
    law,
    picture,
    film,
    angle,
    regimes,
    where,
    candidates,
    experiment,
    dynamics,
    response,
    residuals,
    parameters,
    method,
)


UNIT = re.compile(r"(?<=\d) (?=(?:%|deg|s|ms|Hz|sigma)(?!\w))")
"""The space between a number and its unit."""


@dataclass(frozen=True)
class Made:
    """When and by which command line the page was made; neither is shown where not known."""

    at: datetime | None = None
    command: str | None = None

    @property
    def words(self) -> str | None:
        """The date as the page shows it."""
        return None if self.at is None else f"{self.at:%d %B %Y, %H:%M %Z}".strip().lstrip("0")


def page(story: Story, made: Made = Made()) -> str:
    """The whole page; a section without content is left out."""
    parts = [found for found in (section(story) for section in SECTIONS) if found is not None]
    return page_of(parts, [recording.name for recording in story.recordings], made)


def page_of(parts: Sequence[Section], names: Sequence[str], made: Made = Made()) -> str:
    """A page of these sections, the first of which is its headline; it reports on ``names``."""
    environment = _environment()
    bodies = [
        Markup(environment.get_template(f"{one.name}.html").render(one.values)) for one in parts
    ]
    return environment.get_template("page.html").render(
        sections=list(zip(parts, bodies, strict=True)),
        names=list(dict.fromkeys(names)),
        style=Markup(_read("style.css")),
        script=Markup(_read("zoom.js")),
        made=made.words,
        command=made.command,
        version=__version__,
    )


@functools.cache
def _environment() -> jinja2.Environment:
    # Names of files and recordings are the user's: everything is escaped unless marked.
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(_read),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "bound": bound,
        "chance": chance,
        "coded": coded,
        "degrees": degrees,
        "rounded": rounded,
        "sentence": sentence,
        "signed": signed,
        "spoken": spoken,
        "uncertain": uncertain,
    }
    return environment


def bound(text: str) -> str:
    """Text that no line's end parts between a number and its unit.

    >>> bound("closes 83 % of the gap").split(" ")
    ['closes', '83\\xa0%', 'of', 'the', 'gap']
    """
    return UNIT.sub("\u00a0", text)


def coded(text: str) -> Markup:
    """Text between backquotes, as code."""
    code = Markup("<code>{}</code>")
    parts = [code.format(part) if i % 2 else part for i, part in enumerate(text.split("`"))]
    return Markup("").join(parts)


def _read(name: str) -> str:
    place = files("servosight.app.report").joinpath("templates", name)
    return place.read_text(encoding="utf-8")
