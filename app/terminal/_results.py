"""Results in words and tables, drawn from the same values as their JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from servosight.app.terminal._table import deg, table_of

if TYPE_CHECKING:
    from rich.console import Console

BAR = 24
EIGHTHS = " ▏▎▍▌▋▊▉"
CANDIDATES = 6
FINDINGS = 5
REGIMES = 6


def show_identification(out: Console, result: Mapping[str, Any]) -> None:
    """Parameters with their uncertainty, error against floor, warnings."""
    show_parameters(out, result["parameters"])
    out.print(
        f"rmse {deg(result['rmse_deg'])} over {result['samples']} samples; noise "
        f"{deg(result['noise_deg'])}, floor {deg(result['floor_deg'])}"
    )
    show_fit(out, result["fit_percent"])
    _show_transmissions(out, result.get("transmissions", ()))
    out.print(f"{result['method']}, {result['seconds']:.1f} s, stopped: {result['stopped']}")
    for warning in result["warnings"]:
        out.print(f"note: {warning}")
    show_detectable(out, result.get("detectable", ()))


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
    _show_model(out, result["ladder"][-1], result["warnings"])
    _show_transmissions(out, result.get("transmissions", ()))
    show_candidates(out, result["candidates"], first)
    show_detectable(out, result.get("detectable", ()))
    if result["verdict"] != "no_effect_missing":
        show_where(out, result["where"], f"where the {first} fails")
    if result.get("regimes"):
        show_regimes(out, result["regimes"])
    if result.get("findings"):
        show_findings(out, result["findings"], f"What the error of the {first} shows:")


def _show_model(out: Console, step: Mapping[str, Any], said: Sequence[str]) -> None:
    """A step's parameters, and why some of them are uncertain, unless that is ``said`` before."""
    show_parameters(out, step["parameters"])
    for warning in step["warnings"]:
        if warning not in (*said, *step["held"]):
            out.print(f"note: {warning}")


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
    table = table_of(
        "model", "test data", "", "validation", "fitted", title="error of the model, rms"
    )
    for step in ladder:
        error = step["held_out_rmse_deg"]
        table.add_row(
            _change(step),
            deg(error),
            _bar(error, largest),
            deg(step["validation_rmse_deg"]),
            deg(step["train_rmse_deg"]),
        )
    table.add_row("floor", deg(floor_deg), _bar(floor_deg, largest), "", "")
    out.print(table)
    for step in ladder:
        for words in step.get("held", ()):
            out.print(f"{_change(step)}: {words}")


def show_parameters(out: Console, parameters: Mapping[str, Any]) -> None:
    """Each parameter, rounded to its standard deviation, with that and its unit."""
    from servosight.models.core import uncertain

    table = table_of("parameter", "value", "+- sigma", "unit")
    for name, entry in parameters.items():
        entries = entry if isinstance(entry, list) else [entry]
        for place, one in enumerate(entries, 1):
            label = name if len(entries) == 1 else f"{name} ({place})"
            value, sigma = uncertain(one["value"], one["sigma"])
            table.add_row(label, value.replace("−", "-"), sigma, one["unit"])
    out.print(table)


def show_candidates(out: Console, candidates: Sequence[Mapping[str, Any]], first: str) -> None:
    """The best candidates for the first step, each of them added to the ``first`` model."""
    from servosight.diagnose.selection import SelectionPolicy

    if not candidates:
        return
    least = SelectionPolicy().min_evidence
    title = f"each effect alone added to the {first}; evidence above {least:g} excludes chance"
    table = table_of("candidate", "test data", "evidence", "indistinguishable from", title=title)
    for one in candidates[:CANDIDATES]:
        table.add_row(
            one["effect"],
            deg(one["held_out_rmse_deg"]),
            "-" if one["evidence"] is None else f"{one['evidence']:+.0f}",
            ", ".join(one["confounded_with"]),
        )
    out.print(table)


def show_detectable(out: Console, detectable: Sequence[Mapping[str, Any]]) -> None:
    """Which effects these recordings could have shown, and which not, whatever their size."""
    if not detectable:
        return
    unseen = [one["effect"] for one in detectable if one["value"] is None]
    seen = len(detectable) - len(unseen)
    if unseen:
        out.print(f"These recordings could not have shown {', '.join(unseen)} at any size.")
    out.print(
        f"{seen} effects that the model lacks would have shown from some size on (--json has the "
        "sizes)."
    )
    out.print()


def show_where(out: Console, where: Sequence[Mapping[str, Any]], title: str) -> None:
    """The windows with the largest share of the error of a model that misses the floor."""
    if not where:
        return
    table = table_of(
        "recording",
        "from",
        "to",
        "rms",
        "share",
        "while",
        title=f"{title}; share of its squared error",
    )
    for one in where:
        table.add_row(
            str(one["recording"]),
            f"{one['start_s']:.2f} s",
            f"{one['end_s']:.2f} s",
            deg(one["rmse_deg"]),
            f"{100 * one['share']:.0f} %",
            one["what"].replace("_", " "),
        )
    out.print(table)


def show_regimes(out: Console, regimes: Sequence[Mapping[str, Any]]) -> None:
    """Where held-out data go beyond the fitted ones, and how much of the error is there."""
    from servosight.models.core import rounded

    title = "beyond the fitted data: share of samples and of the squared error of the last model"
    table = table_of(
        "recording", "use", "quantity", "fitted up to", "reached", "samples", "error", title=title
    )
    for one in regimes[:REGIMES]:
        end = one["fitted_high"] if one["beyond"] == "above" else one["fitted_low"]
        table.add_row(
            str(one["recording"]),
            one["use"],
            one["quantity"],
            f"{rounded(end)} {one['unit']}",
            f"{rounded(one['reached'])} {one['unit']}",
            f"{100 * one['share_samples']:.0f} %",
            f"{100 * one['share_error']:.0f} %",
        )
    out.print(table)


def show_findings(out: Console, findings: Sequence[Mapping[str, Any]], title: str) -> None:
    """The largest findings, one a line, each with the rms that it describes."""
    out.print(title)
    for one in findings[:FINDINGS]:
        out.print(f"  {deg(one['size_deg'], 2):>10}  {one['sentence']}")
    if len(findings) > FINDINGS:
        out.print(f"  {len(findings) - FINDINGS} more in the report and the JSON")
    out.print()


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
