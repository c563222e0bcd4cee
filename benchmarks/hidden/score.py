"""From the lines of a results file to the rows of the table: pure functions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from .trial import SEPARABLE

Line = Mapping[str, Any]
LineTest = Callable[[Line], bool]

STRAYED = 1.2
"""An effect outside the catalogue counts where the best single rival misses it by this many floors:
what is nearer may rightly be called explained."""
SIGMAS, SHARE = 3.0, 0.05


@dataclass(frozen=True)
class Share:
    """``hits`` of ``count``, with Wilson's interval of 95 % (Wilson, JASA 22, 1927)."""

    hits: int
    count: int

    @property
    def interval(self) -> tuple[float, float]:
        """Lower and upper end; 0 and 1 where nothing was counted."""
        if self.count == 0:
            return 0.0, 1.0
        z = 1.959964
        n, p = self.count, self.hits / self.count
        centre = (p + z * z / (2 * n)) / (1 + z * z / n)
        half = z / (1 + z * z / n) * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n))
        return centre - half, centre + half


def share(lines: Sequence[Line], test: LineTest) -> Share:
    """How many lines pass a test."""
    return Share(sum(test(line) for line in lines), len(lines))


def hidden(line: Line) -> tuple[str, ...]:
    """What was hidden."""
    return tuple(line["facts"]["hidden"])


def separable(line: Line) -> bool:
    """True where the recording distinguishes what was hidden from every rival."""
    facts = line["facts"]
    if line["row"] == "outside":
        return bool(facts["misfit_deg"][facts["rival"]] >= STRAYED * line["floor_deg"])
    return not facts["hidden"] or bool(facts["cost"] >= SEPARABLE)


def named(line: Line) -> bool:
    """True where exactly what was hidden was named; outside the catalogue, where nothing was."""
    if line["row"] == "outside":
        return not line["named"] and unexplained(line)
    return set(line["named"]) == set(hidden(line))


def unexplained(line: Line) -> bool:
    """True where the verdict is `unexplained`, whatever was added on the way."""
    return bool(line["verdict"] == "unexplained")


def in_group(line: Line) -> bool:
    """True where the truth was named, or reported as indistinguishable from it."""
    wanted = set(hidden(line))
    reported = [set(effects) for effects in line["alternatives"]]
    return named(line) or wanted <= set(line["group"]) or wanted in reported


def right(line: Line) -> bool:
    """True where the diagnosis said all that its recording can distinguish."""
    if line["row"] == "outside":
        return unexplained(line) or not separable(line)
    return named(line) if separable(line) else in_group(line)


def parameters(lines: Sequence[Line]) -> list[tuple[str, float, float, float | None]]:
    """(name, truth, estimate, sigma) of all parameters where exactly the hidden was named."""
    return [
        (name, *numbers)
        for line in lines
        if named(line)
        for name, numbers in line["parameters"].items()
    ]


def close(truth: float, value: float, sigma: float | None) -> bool:
    """Within the larger of three sigma and 5 % of the truth."""
    return abs(value - truth) <= max(SIGMAS * (sigma or 0.0), SHARE * abs(truth))


def explain(line: Line) -> str:
    """One line for a reader who has to find out why a trial went wrong."""
    facts = line["facts"]
    candidates = ", ".join(f"{n} {rmse:.4g} ({e:.0f})" for n, rmse, e in line["candidates"][:4])
    steps = " ".join(
        f"{'+' + a if a else ''}{'-' + r if r else ''}:{rmse:.4g}" for a, r, rmse in line["ladder"]
    )
    values = "; ".join(
        f"{name} " + " ".join(f"{key}={x:.4g}" for key, x in group.items())
        for name, group in facts["hidden"].items()
    )
    return (
        f"{line['row']} --only {line['seed']}: {values or 'nothing'} [{facts['truth']}] -> "
        f"{' + '.join(line['named']) or 'nothing'} ({line['verdict']})\n"
        f"    strength {facts['strength']:.1f}, rival {facts['rival'] or 'linear'} costs "
        f"{facts['cost']:.0f} (own {facts['own_deg']:.4f}), noise {facts['noise_deg']:.4f} taken "
        f"as {line['noise_found_deg']:.4f}{'' if facts['with_sigma'] else ' (no sigma)'}, floor "
        f"{line['floor_deg']:.4f}, {facts['rate_hz']:g} Hz, {facts['duration_s']:.1f} s, "
        f"T {facts['servo']['T']:.4f} xi {facts['servo']['xi']:.2f}\n"
        f"    ladder {steps}\n    candidates {candidates}; group {', '.join(line['group'])}"
    )
