"""How often a sweep's diagnoses find what was hidden, by size, for each setting of the rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from servosight.models.core import Table, spoken
from servosight.models.effects import catalogue
from servosight.scenarios.sweeps.answers._detection import Detection, detection

if TYPE_CHECKING:
    import polars as pl

HIDDEN, STRENGTH = "hidden", "strength"


@dataclass(frozen=True, kw_only=True)
class Found:
    """From which size an effect is found under ``settings``; ``what`` and ``unit`` name it."""

    effect: str
    axis: str
    settings: Mapping[str, Any]
    what: str
    unit: str
    detection: Detection

    @property
    def sentence(self) -> str:
        """The answer, behind the settings it holds for."""
        said = self.detection.sentence(self.what, self.unit)
        return f"{self.where}: {said}" if self.settings else said

    @property
    def where(self) -> str:
        """The settings in words."""
        return ", ".join(f"{name} {value_text(value)}" for name, value in self.settings.items())


def found_by_size(frame: pl.DataFrame, axes: Sequence[str]) -> Table[Found]:
    """One answer for each setting of the axes beside the size's; none where nothing is diagnosed.

    A size is an axis ``effects.EFFECT.PARAMETER`` whose neutral value is 0, or ``strength``. An
    effect counts as found where the diagnosis names it, whatever else it names. Settings of which
    one size alone was tried, as points of drawn axes, give no answer.
    """
    if "effects" not in frame.columns:
        return Table()
    answers = []
    for axis in axes:
        if axis == STRENGTH or _is_size(axis):
            answers += _of_axis(frame, axis, [name for name in axes if name != axis])
    return Table(answers)


def value_text(value: Any) -> str:
    """A setting as sentences show it."""
    return f"{value:g}" if isinstance(value, float) else str(value)


def _is_size(axis: str) -> bool:
    parts = axis.split(".")
    known = catalogue()
    if len(parts) != 3 or parts[0] != "effects" or parts[1] not in known:
        return False
    return known[parts[1]].parameter(parts[2]).neutral == 0.0


def _of_axis(frame: pl.DataFrame, axis: str, others: list[str]) -> list[Found]:
    import polars as pl

    done = frame.filter((pl.col("status") == "done") & (pl.col(axis) > 0.0))
    groups = done.group_by(others, maintain_order=True) if others else [((), done)]
    answers = []
    for values, group in groups:
        settings = dict(zip(others, values, strict=True))
        hidden = str(settings.get(HIDDEN, "")) if axis == STRENGTH else axis.split(".")[1]
        wanted = [name.strip() for name in hidden.split("+") if name.strip()]
        if not wanted or group[axis].n_unique() < 2:
            continue
        right = pl.all_horizontal(pl.col("effects").list.contains(name) for name in wanted)
        counts = (
            group.with_columns(right.alias("right"))
            .group_by(axis)
            .agg(pl.col("right").sum(), pl.len().alias("of"))
            .sort(axis)
        )
        answers.append(
            Found(
                effect="+".join(wanted),
                axis=axis,
                settings=settings,
                **_words(axis, wanted),
                detection=detection(
                    counts[axis].to_list(), counts["right"].to_list(), counts["of"].to_list()
                ),
            )
        )
    return answers


def _words(axis: str, effects: Sequence[str]) -> dict[str, str]:
    if axis == STRENGTH:
        name = " and ".join(map(spoken, effects))
        return {"what": f"strength of {name}", "unit": ""}
    _, effect, name = axis.split(".")
    parameter = catalogue()[effect].parameter(name)
    unit = "" if parameter.unit == "-" else parameter.unit
    return {"what": f"{effect.replace('_', ' ')} {name.replace('_', ' ')}", "unit": unit}
