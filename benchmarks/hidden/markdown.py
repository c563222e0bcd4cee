"""Tables of the page of results."""

from __future__ import annotations

from collections.abc import Iterable

from .score import Share


def percent(counted: Share) -> tuple[str, str, str]:
    """A share, its interval, and of how many."""
    if counted.count == 0:
        return "-", "-", "0"
    low, high = counted.interval
    measured = f"{100 * counted.hits / counted.count:.1f} %"
    return measured, f"{100 * low:.1f} to {100 * high:.1f} %", str(counted.count)


def markdown(rows: Iterable[tuple[str, ...]]) -> str:
    """Rows of cells as a Markdown table."""
    return "\n".join("| " + " | ".join(row) + " |" for row in rows)
