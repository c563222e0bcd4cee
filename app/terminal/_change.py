"""What differs between two servos, in words and tables, drawn from the same values as the JSON."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from servosight.app.terminal._table import deg, table_of

if TYPE_CHECKING:
    from rich.console import Console

STEP_METRICS = {
    "bandwidth_hz": ("bandwidth", 1.0, "Hz"),
    "rise_time_s": ("rise time, 10 to 90 %", 1e3, "ms"),
    "overshoot": ("overshoot", 100.0, "%"),
    "settling_time_s": ("settling time, to 2 %", 1e3, "ms"),
}
"""What is compared of two servos' motion: in words, with the factor to the unit shown."""


def show_change(out: Console, result: Mapping[str, Any]) -> None:
    """What differs between two servos: in words, each parameter, what it can mean."""
    from servosight.models.core import uncertain

    out.print(f"{result['headline']}.")
    table = table_of("parameter", "a", "b", "difference", "+- sigma", "sigmas", "unit")
    for one in result["parameters"]:
        before, after = (
            "-" if one[side] is None else uncertain(one[side], one[f"{side}_sigma"])[0]
            for side in "ab"
        )
        difference = one["difference"]
        shown, spread = ("-", "-") if difference is None else uncertain(difference, one["sigma"])
        ratio = "-" if one["sigmas"] is None or not one["sigma"] else f"{one['sigmas']:+.1f}"
        cells = [before, after, shown, spread, ratio]
        name = f"{one['name']} *" if one["changed"] else one["name"]
        table.add_row(name, *(cell.replace("−", "-") for cell in cells), one["unit"])
    out.print(table)
    _show_steps(out, result)
    if any(one["changed"] for one in result["parameters"]):
        out.print("* changed by more than chance accounts for")
    out.print(result["summary"])
    for words in result["sentences"]:
        if words not in result["summary"]:
            out.print(words)
    for name in "ab":
        side = result[name]
        if side["rmse_deg"] is not None:
            out.print(
                f"{name} ({', '.join(side['recordings'])}): error {deg(side['rmse_deg'])}, with "
                f"the other's model {deg(side['other_rmse_deg'])}, floor {deg(side['floor_deg'])}"
            )
    for warning in result["warnings"]:
        out.print(f"note: {warning}")


def _show_steps(out: Console, result: Mapping[str, Any]) -> None:
    """How fast either servo is and how it answers a step, with the sigma that its fit leaves."""
    from servosight.models.core import uncertain

    sides = [result[name]["dynamics"] for name in "ab"]
    if None in sides:
        return
    table = table_of(f"step of {sides[0]['step_deg']:g} deg", "a", "b", "unit")
    for name, (words, factor, unit) in STEP_METRICS.items():
        cells = []
        for one in (side[name] for side in sides):
            if one is None:
                cells.append("-")
                continue
            sigma = None if one["sigma"] is None else factor * one["sigma"]
            value, spread = uncertain(factor * one["value"], sigma)
            cells.append(f"{value} +- {spread}" if sigma else value)
        table.add_row(words, *(cell.replace("−", "-") for cell in cells), unit)
    out.print(table)
