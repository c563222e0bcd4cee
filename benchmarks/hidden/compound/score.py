"""Scores of compound trials: pure functions of the lines of a results file."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from hidden.score import Line

from .facts import ABSENT, MATERIAL

AT_FLOOR = 1.1
SIGMAS = 2.0


def material(line: Line) -> dict[str, set[str]]:
    """Effects that must be named, each with all names that will do for it.

    Of effects that take each other's place and are material only together, one must.
    """
    facts = line["facts"]
    alone = {
        name: {name, *_passing(facts, name)}
        for name, weight in facts["weights"].items()
        if weight >= MATERIAL
    }
    together = {
        names: set(names.split(" or "))
        for names, weight in facts.get("together", {}).items()
        if weight >= MATERIAL
    }
    return alone | {names: some for names, some in together.items() if not some & alone.keys()}


def allowed(line: Line) -> set[str]:
    """Effects that may be named: what is not absent, and what passes for it."""
    facts = line["facts"]
    weights = {**facts["weights"], **facts.get("together", {})}
    there = {name for name, weight in weights.items() if weight >= ABSENT}
    there = {name for names in there for name in names.split(" or ")}
    return there.union(*(_passing(facts, name) for name in there))


def _passing(facts: Mapping[str, Any], name: str) -> set[str]:
    stand_ins = facts["stand_ins"].get(name, {})
    return {other for other, added in stand_ins.items() if added < MATERIAL}


def complete(line: Line) -> bool:
    """True where every material effect is named."""
    named = set(line["named"])
    return all(named & names for names in material(line).values())


def foreign(line: Line) -> set[str]:
    """What is named and is not there."""
    return set(line["named"]) - allowed(line)


def clean(line: Line) -> bool:
    """True where nothing foreign is named."""
    return not foreign(line)


def exact(line: Line) -> bool:
    """True where every material effect is named and nothing foreign."""
    return complete(line) and clean(line)


def at_floor(line: Line) -> bool:
    """True where the test error is within 1.1 of what the true effects reach."""
    return bool(line["over_floor"] <= AT_FLOOR)


def pairs(lines: Sequence[Line]) -> list[tuple[Line, Line]]:
    """Lines of the two runs of one servo."""
    first = {line["seed"]: line for line in lines if line["row"] == "compound"}
    again = {line["seed"]: line for line in lines if line["row"] == "compound-again"}
    return [(first[seed], again[seed]) for seed in sorted(first.keys() & again.keys())]


def same_names(pair: tuple[Line, Line]) -> bool:
    """True where both runs name the same effects."""
    a, b = pair
    return set(a["named"]) == set(b["named"])


def deviations(pair: tuple[Line, Line]) -> list[float]:
    """Differences of the shared parameters of two runs, in sigma of the difference."""
    a, b = (line["parameters"] for line in pair)
    found = []
    for name in a.keys() & b.keys():
        (_, one, sigma), (_, other, sigma_too) = a[name], b[name]
        if sigma is not None and sigma_too is not None and sigma + sigma_too > 0.0:
            found.append(abs(one - other) / math.hypot(sigma, sigma_too))
    return found


def strays(line: Line) -> list[float]:
    """Distances of the parameters from what other runs of the servo give, in sigma; infinite where
    no finite value is best there."""
    elsewhere = line.get("elsewhere", {})
    return [
        math.inf if elsewhere[name] is None else abs(value - elsewhere[name]) / sigma
        for name, (_, value, sigma) in line["parameters"].items()
        if sigma and name in elsewhere
    ]


def agree(pair: tuple[Line, Line]) -> bool:
    """True where the same is named, and no parameter is off by more than chance allows.

    That is 2 sigma for one parameter; of n the largest may be off by what one of n exceeds as
    rarely as 2 sigma are exceeded by one alone (Sidak 1967).
    """
    off = deviations(pair)
    return same_names(pair) and all(z <= _largest(len(off)) for z in off)


def _largest(count: int) -> float:
    """Deviation that the largest of ``count`` exceeds as rarely as one alone exceeds 2 sigma."""
    from statistics import NormalDist

    normal = NormalDist()
    once = 2.0 * normal.cdf(SIGMAS) - 1.0
    return normal.inv_cdf(0.5 * (1.0 + once ** (1.0 / max(count, 1))))


def explain(line: Line) -> str:
    """One paragraph for a reader who has to find out why a trial went wrong."""
    facts = line["facts"]
    weights = ", ".join(
        f"{name} {weight:.1f}" for name, weight in sorted(facts["weights"].items(), key=_second)
    )
    steps = " ".join(
        f"{'+' + a if a else ''}{'-' + r if r else ''}:{v:.4g}/{t:.4g}"
        for a, r, v, t in line["ladder"]
    )
    missed = [name for name, names in material(line).items() if not names & set(line["named"])]
    return (
        f"{line['row']} --only {line['seed']}: {facts['family']}, gains "
        f"{', '.join(f'{gain:g}' for gain in facts['gains'])}; weights {weights} -> "
        f"{' + '.join(line['named']) or 'nothing'} ({line['verdict']})\n"
        f"    missed {', '.join(missed) or 'nothing'}; foreign "
        f"{', '.join(sorted(foreign(line))) or 'nothing'}; test error {line['over_floor']:.2f} "
        f"floors of {line['floor_deg']:.4f} deg; noise {facts['noise_deg']:.4f} taken as "
        f"{line['noise_found_deg']:.4f}, own {facts['own_deg']:.4f}; {facts['samples']} samples "
        f"at {facts['rate_hz']:.0f} Hz; {line['cpu_s']:.0f} s\n    steps {steps}"
    )


def _second(pair: tuple[str, float]) -> float:
    return -pair[1]
