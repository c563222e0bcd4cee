"""A table and a cell with an angle, as the terminal shows them."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.table import Table


def deg(value: float | None, digits: int = 3) -> str:
    """An angle with its unit; a dash where there is none."""
    from servosight.models.core import degrees

    return "-" if value is None else degrees(value, digits)


def table_of(*columns: str, title: str | None = None) -> Table:
    """An empty table with these columns, none of which breaks its lines."""
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE, title=title, title_justify="left", title_style="")
    for column in columns:
        table.add_column(column, no_wrap=True)
    return table
