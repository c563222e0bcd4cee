"""docs/paper.md: what is generated stands between marks, the text around it is written by hand."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from servosight.app.report.figure import Paint, drawn
from servosight.models.core import write_text

from .search_counts import Tally

DOCS = Path(__file__).parents[2] / "docs"
PAGE = DOCS / "paper.md"
PICTURES = DOCS / "pictures" / "paper"


def put(name: str, text: str) -> None:
    """Replace what stands between the marks of ``name``; KeyError where the page lacks them."""
    begin, end = f"<!-- {name} -->", f"<!-- /{name} -->"
    page = PAGE.read_text(encoding="utf-8")
    fresh, count = re.subn(
        f"{re.escape(begin)}.*?{re.escape(end)}",
        lambda _: f"{begin}\n{text}\n{end}",
        page,
        flags=re.DOTALL,
    )
    if count != 1:
        raise KeyError(f"{PAGE.name} has {count} places marked {begin} ... {end}, expected one")
    write_text(PAGE, fresh)


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def share(found: Tally) -> str:
    """A probability with its interval, in percent."""
    low, high = (100.0 * edge for edge in found.interval)
    return f"{100.0 * found.converged / found.runs:.1f} % ({low:.1f} to {high:.1f})"


def picture(name: str, size: tuple[float, float], alt: str, paint: Paint) -> str:
    """Draw a figure as the report draws its own, into docs/pictures/paper; its Markdown."""

    def on_white(figure: object) -> None:
        figure.set_facecolor("white")  # type: ignore[attr-defined]
        paint(figure)  # type: ignore[arg-type]

    PICTURES.mkdir(parents=True, exist_ok=True)
    write_text(PICTURES / f"{name}.svg", str(drawn(name, size, alt, on_white)) + "\n")
    return f"![{alt}](pictures/paper/{name}.svg)"
