"""The page on two runs of one servo, drawn from the results of the runs that are there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import hypot

from servosight.models.effects import catalogue

from .logs import RunResult


def page(results: Mapping[str, RunResult], servos: Sequence[str], runs: Sequence[str]) -> str:
    """The page; ``results`` by servo and run, joined by a hyphen."""
    rows, verdicts = [], []
    for servo in servos:
        both = [results.get(f"{servo}-{run}") for run in runs]
        rows += [_row(servo, run, one) for run, one in zip(runs, both, strict=True) if one]
        if all(both):
            verdicts.append(_verdict(servo, both[0] or {}, both[1] or {}))
    return _PAGE.format(rows="\n".join(rows), verdicts="\n".join(verdicts))


_PAGE = """# Real servos: the same answer twice

Written by `python benchmarks/real_pairs.py` from logs in the folder `SERVOSIGHT_DATA`. Each log of
six seconds is diagnosed by itself (`diagnose --auto`). Behind each effect that is named stands the
share of ten parts of the data that name it. *Open* are the effects of the model that others do
without which do as well, as far as the scatter of the errors from second to second tells, with what
those have in their place (`one_of`); they are not named. Two runs agree where neither names what
the other rules out: what the other would have shown at that size (`detectable`), and neither names
nor leaves open.

| servo and gain | run | named | open | error over floor |
| --- | --- | --- | --- | --- |
{rows}

| servo and gain | same names | agree | a set that both allow | named by both | T differs by |
| --- | --- | --- | --- | --- | --- |
{verdicts}
"""


def consistent(first: RunResult, second: RunResult) -> bool:
    """True where a set of effects that one run allows is allowed by the other, too."""
    allowed = [
        {frozenset((*one["named"], *one["one_of"])), *map(frozenset, one["equivalents"])}
        for one in (first, second)
    ]
    return bool(allowed[0] & allowed[1])


def agree(first: RunResult, second: RunResult) -> bool:
    """True where neither run names an effect that the other rules out."""
    return not _denied(first, second) and not _denied(second, first)


def _denied(names: RunResult, other: RunResult) -> list[str]:
    """The effects that one run names, and the other, which would have shown them, rules out."""
    open_ = {*other["one_of"], *(one for some in other["one_of"].values() for one in some)}
    missing = (name for name in names["named"] if name not in {*other["named"], *open_})
    shown = other["shown_from"]  # of what its model lacks: what that has and does not name is open
    return [name for name in missing if name in shown and _would_show(shown[name], names)]


def _would_show(limit: tuple[str, float | None, bool], names: RunResult) -> bool:
    """True where the size of an effect is beyond that from which on a run shows it."""
    parameter, value, below = limit
    if value is None:
        return False
    size = names["parameters"][_of_whole(parameter, names)][0]
    return bool(abs(size) <= abs(value) if below else abs(size) >= abs(value))


def _of_whole(parameter: str, names: RunResult) -> str:
    """The parameter, or of a special case, which is named alone, that of the effect in the model
    which contains it: its own come first there."""
    if parameter in names["parameters"]:
        return parameter
    name, _, own = parameter.partition(".")
    known = catalogue()
    place = [one.name for one in known[name].parameters].index(own)
    wholes = (one for one in known.values() if name in one.contains)
    could = (f"{one.id}.{one.parameters[place].name}" for one in wholes)
    return next(one for one in could if one in names["parameters"])


def _row(servo: str, run: str, one: RunResult) -> str:
    shares = one["stability"]
    named = ", ".join(f"{name} {shares.get(name, 0.0):.1f}" for name in one["named"]) or "nothing"
    open_ = "; ".join(" or ".join([name, *others]) for name, others in one["one_of"].items())
    return f"| {servo} | `{run}` | {named} | {open_ or 'none'} | {one['over_floor']:.1f} |"


def _verdict(servo: str, first: RunResult, second: RunResult) -> str:
    named = set(first["named"]), set(second["named"])
    answers = named[0] == named[1], agree(first, second), consistent(first, second)
    words = " | ".join("yes" if answer else "no" for answer in answers)
    common = ", ".join(sorted(named[0] & named[1])) or "none"
    return f"| {servo} | {words} | {common} | {_apart(first, second)} |"


def _apart(first: RunResult, second: RunResult) -> str:
    """The difference of T, in its own sigmas."""
    (one, its), (other, own) = first["parameters"]["T"], second["parameters"]["T"]
    if its is None or own is None:
        return "no sigma"
    return f"{abs(one - other) / max(hypot(its, own), 1e-12):.1f} sigma"
