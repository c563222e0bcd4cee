"""The rows of a sweep, grouped by its axes: errors beside their limit, how often it is right."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from servosight.models.core import Table
from servosight.scenarios.sweeps.answers._found import Found, found_by_size
from servosight.scenarios.sweeps.run import Facts

if TYPE_CHECKING:
    import polars as pl

CORE = ("k", "T", "xi")
_NUMBERS = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?", re.IGNORECASE)
_MOST_KINDS = 10


@dataclass(frozen=True, kw_only=True)
class Summary:
    """What a sweep found: its keys are those of ``servosight results --json``.

    ``table`` has one row for each combination of the axes: ``cells`` and how many ``failed``;
    ``k_error`` and so on, the rms over the seeds of the relative error; ``k_bound``, the smallest
    that an unbiased estimate can have; ``named``, the share whose diagnosis names the hidden
    effects and nothing else; ``seconds`` of a cell, the median. ``found`` says from which size an
    effect is found, where the sweep has sizes.
    """

    schema: int
    name: str
    about: str
    axes: tuple[str, ...]
    cells: int
    planned: int
    failed: int
    left_out: int
    kinds: Mapping[str, int]
    table: Table[Mapping[str, Any]]
    found: Table[Found]

    @property
    def headline(self) -> str:
        """How much there is."""
        rest = f", {self.failed} failed" if self.failed else ""
        missing = self.planned - self.cells
        rest += f", {missing} still to run" if missing > 0 else ""
        rest += (
            f"; {self.left_out} rows of other code or settings left out" if self.left_out else ""
        )
        return f"{self.name}: {self.cells} cells over {', '.join(self.axes)}{rest}"

    @property
    def failures(self) -> list[str]:
        """A sentence for each kind of failure, the most frequent first."""
        return [f"{count} failed: {kind}" for kind, count in self.kinds.items()]


def summary(frame: pl.DataFrame, facts: Facts) -> Summary:
    """Group the rows of a sweep by its axes. ``facts`` is what its folder says of it."""
    import polars as pl

    axes = [name for name in facts.axes if name in frame.columns]
    failed = frame.filter(pl.col("status") != "done")
    kinds = Counter(_NUMBERS.sub("#", error) for error in failed["error"] if error)
    table = _grouped(frame, axes)
    return Summary(
        schema=1,
        name=facts.name,
        about=facts.about,
        axes=tuple(axes),
        cells=frame.height,
        planned=facts.cells,
        failed=failed.height,
        left_out=facts.left_out,
        kinds=dict(kinds.most_common(_MOST_KINDS)),
        table=Table(table.to_dicts()),
        found=found_by_size(frame, axes),
    )


def _grouped(frame: pl.DataFrame, axes: list[str]) -> pl.DataFrame:
    import polars as pl

    found = [
        pl.len().alias("cells"),
        (pl.col("status") != "done").sum().alias("failed"),
    ]
    errors = [name for name in frame.columns if name.endswith("_error")]
    for error in errors:
        bound = f"{error.removesuffix('_error')}_bound"
        found.append((pl.col(error) ** 2).mean().sqrt().alias(error))
        if bound in frame.columns:
            found.append((pl.col(bound) ** 2).mean().sqrt().alias(bound))
    if "named" in frame.columns:
        found.append(pl.col("named").mean().alias("named"))
    found.append(pl.col("seconds").median().alias("seconds"))
    return frame.group_by(axes).agg(found).sort(axes)
