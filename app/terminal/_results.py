"""Results in words and tables, drawn from the same values as their JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

BAR = 24
EIGHTHS = " ▏▎▍▌▋▊▉"
CANDIDATES = 6
FINDINGS = 5
REGIMES = 6
LEAST_DEG = 1e-9
STEP_METRICS = {
    "bandwidth_hz": ("bandwidth", 1.0, "Hz"),
    "rise_time_s": ("rise time, 10 to 90 %", 1e3, "ms"),
    "overshoot": ("overshoot", 100.0, "%"),
    "settling_time_s": ("settling time, to 2 %", 1e3, "ms"),
}
"""What is compared of two servos' motion: in words, with the factor to the unit shown."""


def show_identification(out: Console, result: Mapping[str, Any]) -> None:
    """Parameters with their uncertainty, error against floor, warnings."""
    show_parameters(out, result["parameters"])
    out.print(
        f"rmse {_deg(result['rmse_deg'])} over {result['samples']} samples; noise "
        f"{_deg(result['noise_deg'])}, floor {_deg(result['floor_deg'])}"
    )
    show_fit(out, result["fit_percent"])
    _show_transmissions(out, result.get("transmissions", ()))
    out.print(f"{result['method']}, {result['seconds']:.1f} s, stopped: {result['stopped']}")
    for warning in result["warnings"]:
        out.print(f"note: {warning}")
    show_blind(out, result.get("detectable", ()))


def _show_transmissions(out: Console, found: Sequence[Mapping[str, Any]]) -> None:
    """Ratio and play between horn and surface, of each recording that has both."""
    for one in found:
        out.print(f"{one['recording']}: {one['sentence']}")


def show_fit(out: Console, fit_percent: float | None, what: str = "") -> None:
    """How much of the motion a model reproduces; nothing where that is not known."""
    from servosight.models.core import percent

    if fit_percent is not None:
        out.print(f"fit (NRMSE){what} {percent(fit_percent)} %".replace("−", "-"))


def show_diagnosis(out: Console, result: Mapping[str, Any]) -> None:
    """The ladder, the verdict, the parameters, where it fails, what to try."""
    from servosight.diagnose import named_model

    first = named_model(result["ladder"][0]["effects"], result["ladder"][0]["base"])
    show_ladder(out, result["ladder"], result["floor_deg"])
    show_fit(out, result["ladder"][-1]["fit_percent"], " of the last model on test data:")
    show_verdict(out, result)
    show_parameters(out, result["ladder"][-1]["parameters"])
    _show_transmissions(out, result.get("transmissions", ()))
    show_candidates(out, result["candidates"])
    show_blind(out, result.get("detectable", ()))
    if result["verdict"] != "no_effect_missing":
        show_where(out, result["where"], f"where the {first} fails")
    if result.get("regimes"):
        show_regimes(out, result["regimes"])
    if result.get("findings"):
        show_findings(out, result["findings"], f"What the error of the {first} shows:")


def show_verdict(out: Console, result: Mapping[str, Any]) -> None:
    """The verdict, a line for each part of it, what to do next, and what is uncertain."""
    from servosight.diagnose import alternative_words

    effects = result["effects"]
    out.print(f"{result['headline']}. {result['summary']}")
    if effects and result.get("alternatives"):
        out.print(alternative_words(effects, result["alternatives"]))
    for name in effects:
        out.print(f"What {name} is and how to confirm it: servosight effects {name}")
    for warning in result.get("warnings", ()):
        out.print(f"note: {warning}")
    if result.get("next_experiment"):
        out.print(f"To learn more: {result['next_experiment']}")
    out.print()


def show_ladder(out: Console, ladder: Sequence[Mapping[str, Any]], floor_deg: float) -> None:
    """One step a line with its error on test data as a bar, the floor, and what steps hold."""
    largest = max([floor_deg, *(step["held_out_rmse_deg"] or 0.0 for step in ladder)])
    table = _table(
        "model", "test data", "", "validation", "fitted", title="error of the model, rms"
    )
    for step in ladder:
        error = step["held_out_rmse_deg"]
        table.add_row(
            _change(step),
            _deg(error),
            _bar(error, largest),
            _deg(step["validation_rmse_deg"]),
            _deg(step["train_rmse_deg"]),
        )
    table.add_row("floor", _deg(floor_deg), _bar(floor_deg, largest), "", "")
    out.print(table)
    for step in ladder:
        for words in step.get("held", ()):
            out.print(f"{_change(step)}: {words}")


def show_parameters(out: Console, parameters: Mapping[str, Any]) -> None:
    """Each parameter, rounded to its standard deviation, with that and its unit."""
    from servosight.models.core import uncertain

    table = _table("parameter", "value", "+- sigma", "unit")
    for name, entry in parameters.items():
        entries = entry if isinstance(entry, list) else [entry]
        for place, one in enumerate(entries, 1):
            label = name if len(entries) == 1 else f"{name} ({place})"
            value, sigma = uncertain(one["value"], one["sigma"])
            table.add_row(label, value.replace("−", "-"), sigma, one["unit"])
    out.print(table)


def show_candidates(out: Console, candidates: Sequence[Mapping[str, Any]]) -> None:
    """The best candidates for the first step."""
    if not candidates:
        return
    table = _table("candidate", "test data", "evidence", "indistinguishable from")
    for one in candidates[:CANDIDATES]:
        table.add_row(
            one["effect"],
            _deg(one["held_out_rmse_deg"]),
            "-" if one["evidence"] is None else f"{one['evidence']:.1f}",
            ", ".join(one["confounded_with"]),
        )
    out.print(table)


def show_blind(out: Console, detectable: Sequence[Mapping[str, Any]]) -> None:
    """Which effects these recordings could have shown, and which not, whatever their size."""
    if not detectable:
        return
    unseen = [one["effect"] for one in detectable if one["value"] is None]
    seen = f"{len(detectable) - len(unseen)} further effects would have shown from some size on"
    if unseen:
        out.print(f"These recordings could not have shown {', '.join(unseen)} at any size.")
    out.print(f"{seen} (--json has the sizes).")
    out.print()


def show_where(out: Console, where: Sequence[Mapping[str, Any]], title: str) -> None:
    """The windows with the largest share of the error of a model that misses the floor."""
    if not where:
        return
    table = _table("recording", "from", "to", "rms", "share", "while", title=title)
    for one in where:
        table.add_row(
            str(one["recording"]),
            f"{one['start_s']:.2f} s",
            f"{one['end_s']:.2f} s",
            _deg(one["rmse_deg"]),
            f"{100 * one['share']:.0f} %",
            one["what"].replace("_", " "),
        )
    out.print(table)


def show_regimes(out: Console, regimes: Sequence[Mapping[str, Any]]) -> None:
    """Where held-out data go beyond the fitted ones, and how much of the error is there."""
    title = "beyond the fitted data: share of samples and of the squared error of the last model"
    table = _table(
        "recording", "", "quantity", "fitted up to", "reached", "samples", "error", title=title
    )
    for one in regimes[:REGIMES]:
        end = one["fitted_high"] if one["beyond"] == "above" else one["fitted_low"]
        table.add_row(
            str(one["recording"]),
            one["use"],
            one["quantity"],
            f"{end:.4g} {one['unit']}",
            f"{one['reached']:.4g} {one['unit']}",
            f"{100 * one['share_samples']:.0f} %",
            f"{100 * one['share_error']:.0f} %",
        )
    out.print(table)


def show_findings(out: Console, findings: Sequence[Mapping[str, Any]], title: str) -> None:
    """The largest findings, one a line, each with the rms that it describes."""
    out.print(title)
    for one in findings[:FINDINGS]:
        out.print(f"  {_deg(one['size_deg'], 2):>10}  {one['sentence']}")
    if len(findings) > FINDINGS:
        out.print(f"  {len(findings) - FINDINGS} more in the report and the JSON")
    out.print()


def show_change(out: Console, result: Mapping[str, Any]) -> None:
    """What differs between two servos: in words, each parameter, what it can mean."""
    from servosight.models.core import uncertain

    out.print(f"{result['headline']}.")
    table = _table("parameter", "a", "b", "difference", "+- sigma", "sigmas", "unit")
    for one in result["parameters"]:
        before, after = (
            "-" if one[side] is None else uncertain(one[side], one[f"{side}_sigma"])[0]
            for side in "ab"
        )
        difference = one["difference"]
        shown, spread = ("-", "-") if difference is None else uncertain(difference, one["sigma"])
        ratio = "-" if one["sigmas"] is None else f"{one['sigmas']:+.1f}"
        cells = [before, after, shown, spread, ratio]
        name = f"{one['name']} *" if one["changed"] else one["name"]
        table.add_row(name, *(cell.replace("−", "-") for cell in cells), one["unit"])
    out.print(table)
    _show_steps(out, result)
    if any(one["changed"] for one in result["parameters"]):
        out.print("* changed by more than chance accounts for")
    for words in result["sentences"]:
        out.print(words)
    for name in "ab":
        side = result[name]
        if side["rmse_deg"] is not None:
            out.print(
                f"{name} ({', '.join(side['recordings'])}): error {_deg(side['rmse_deg'])}, with "
                f"the other's model {_deg(side['other_rmse_deg'])}, floor {_deg(side['floor_deg'])}"
            )
    for warning in result["warnings"]:
        out.print(f"note: {warning}")


def _show_steps(out: Console, result: Mapping[str, Any]) -> None:
    """How fast either servo is and how it answers a step, with the sigma that its fit leaves."""
    from servosight.models.core import uncertain

    sides = [result[name]["dynamics"] for name in "ab"]
    if None in sides:
        return
    table = _table(f"step of {sides[0]['step_deg']:g} deg", "a", "b", "unit")
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


def _change(step: Mapping[str, Any]) -> str:
    """What a step added to the model and took from it."""
    added, removed = step["added"], step.get("removed")
    signs = ([f"+ {added}"] if added else []) + ([f"- {removed}"] if removed else [])
    return ", ".join(signs) or ", ".join([step["base"], *(f"+ {name}" for name in step["effects"])])


def _bar(value: float | None, largest: float) -> str:
    """A bar in eighths of a character; whatever is above zero shows."""
    if not value or largest <= 0.0:
        return ""
    eighths = max(1, round(8 * BAR * value / largest))
    return "█" * (eighths // 8) + EIGHTHS[eighths % 8].strip()


def _deg(value: float | None, digits: int = 4) -> str:
    return "-" if value is None else f"{value:.{digits}g} deg"


def _table(*columns: str, title: str | None = None) -> Table:
    from rich import box
    from rich.table import Table

    table = Table(box=box.SIMPLE, title=title, title_justify="left", title_style="")
    for column in columns:
        table.add_column(column, no_wrap=True)
    return table
