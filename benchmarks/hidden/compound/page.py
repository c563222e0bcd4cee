"""The table of the compound rows, from whatever lines there are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from hidden.markdown import markdown, percent
from hidden.score import Line, Share

from . import score

ROWS = ("compound", "compound-again")
HEAD = ("", "goal", "measured", "interval", "count", "")


def compound_table(lines: Sequence[Line]) -> str:
    """One row a goal, and what was named that is not there."""
    rows = [HEAD, ("---",) * len(HEAD)]
    for name, what in (
        ("compound", "three to six effects at once"),
        ("compound-faults", "the same, with repeated samples and read errors in the log"),
    ):
        mine = [line for line in lines if line["row"] == name]
        rows += [
            _share(f"{what}: every material effect named, nothing foreign", "80 %", mine,
                   score.exact, _effects(mine)),
            _share("every material effect named", "", mine, score.complete, ""),
            _share("nothing foreign named", "95 %", mine, score.clean, _strangers(mine)),
            _share("test error within 1.1 of the floor", "90 %", mine, score.at_floor,
                   _median(mine, "over_floor", "median {:.2f} floors")),
            _share("verdict `explained`", "", mine, _explained,
                   _median(mine, "cpu_s", "median {:.0f} s of processor time")),
        ]  # fmt: skip
    pairs = score.pairs(lines)
    off = [z for pair in pairs for z in score.deviations(pair) if score.same_names(pair)]
    near = sum(z <= score.SIGMAS for z in off)
    strays = [z for line in lines if line["row"] in ROWS for z in score.strays(line)]
    held = sum(z <= score.SIGMAS for z in strays)
    rows += [
        _share("two disjoint runs of one servo: the same effects, parameters within 2 sigma",
               "80 %", pairs, score.agree, ""),
        _share("the same effects named by both", "", pairs, score.same_names, ""),
        ("parameters within 2 sigma of the other run's, where the same is named", "90 to 97 %",
         *percent(Share(near, len(off))), ""),
        ("parameters within 2 sigma of what eight other runs give, whatever is named",
         "90 to 97 %", *percent(Share(held, len(strays))), ""),
    ]  # fmt: skip
    return markdown(rows)


def _share(
    what: str, goal: str, cases: Sequence[Any], test: Callable[[Any], bool], note: str
) -> tuple[str, ...]:
    return what, goal, *percent(Share(sum(map(test, cases)), len(cases))), note


def _explained(line: Line) -> bool:
    return bool(line["verdict"] == "explained")


def _effects(lines: Sequence[Line]) -> str:
    wanted = [names for line in lines for names in score.material(line).items()]
    found = sum(bool(names & set(line["named"])) for line in lines
                for names in score.material(line).values())  # fmt: skip
    return f"{found} of {len(wanted)} material effects" if wanted else ""


def _strangers(lines: Sequence[Line]) -> str:
    counted = Counter(name for line in lines for name in score.foreign(line))
    return ", ".join(f"{name} {count}" for name, count in counted.most_common(4))


def _median(lines: Sequence[Line], key: str, words: str) -> str:
    return words.format(np.median([line[key] for line in lines])) if lines else ""
