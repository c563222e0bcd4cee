"""The table of the hidden-effect benchmark, from whatever lines there are."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from . import score
from .compound.page import compound_table
from .compound.trial import COMPOUND_ROWS
from .markdown import markdown, percent
from .score import Line, Share

MADE_BY = {"twin": "twin", "fixed steps": "fixed steps", "equation": "the equation"}
OTHER_PHYSICS = ("single", "weak", "pair", "coarse")
WANTED_OVER_FLOOR = 1.05
WANTED_CLOSED = 0.8


def page(lines: Sequence[Line], command: str) -> str:
    """Markdown with every row of the table; rows without trials say so."""
    several = [line for line in lines if line["row"] in COMPOUND_ROWS]
    lines = [line for line in lines if line["row"] not in COMPOUND_ROWS]
    return f"""# Hidden effects: the benchmark

Written by `{command}` from {len(lines) + len(several)} trials; [hidden.md](../hidden.md)
says what the words mean. Intervals are Wilson's, 95 %.

{table(lines)}

## Several effects at once

{compound_table(several)}

![Which effect was named for which](../pictures/hidden/confusion.png)

![How often it was named, against its strength](../pictures/hidden/detection.png)

![Errors of the parameters, in sigmas](../pictures/hidden/parameters.png)

![Processor time of a diagnosis](../pictures/hidden/time.png)

## Named wrong

{wrong(lines)}
"""


def table(lines: Sequence[Line]) -> str:
    """One row a goal."""
    rows = {name: [line for line in lines if line["row"] == name] for name in _names(lines)}

    def of(name: str) -> list[Line]:
        return rows.get(name, [])

    def clear(name: str) -> list[Line]:
        return [line for line in of(name) if score.separable(line)]

    physics = [line for name in OTHER_PHYSICS for line in of(name)]
    explained = [line for line in physics if line["verdict"] == "explained"]
    unnamed = [line for line in clear("outside") if score.unexplained(line)]
    vague = [line for line in physics if not score.separable(line)]
    cells = [
        _counted("one hidden effect, strength 3 to 30, separable: named exactly", "99 %",
                 clear("single"), score.named),
        _counted("the same, strength 1.5 to 3", "90 %", clear("weak"), score.named),
        _counted("the same, strength 0.75 to 1.5", "", clear("faint"), score.named),
        _counted("nothing hidden: nothing named", "99 %", of("nothing"), score.named),
        _counted("two hidden effects, each 3 to 30, separable: both named, nothing else", "95 %",
                 clear("pair"), score.named),
        _counted("not separable: the group contains the truth", "", vague, score.in_group),
        _over_floor(explained),
        _parameters("parameters within the larger of 3 sigma and 5 % of the truth", "97 %",
                    physics, score.close),
        _parameters("on data made by the equation itself: within 2 sigma", "94 to 97 %",
                    of("equation"), _within_two),
        _counted("30 frames/s, or noise from 0.2 deg; separable, strength 1.5 to 30: named", "90 %",
                 clear("coarse"), score.named),
        _counted("outside the catalogue: `unexplained`", "95 %", clear("outside"),
                 score.unexplained),
        _counted("outside the catalogue: `unexplained`, and nothing named on the way", "",
                 clear("outside"), score.named),
        _counted("its sparse law closes at least 80 % of the gap between error and floor", "",
                 unnamed, _lawful),
        _counted("through the video, strength 3 to 30 over 0.02 deg, separable: named exactly", "",
                 clear("video"), score.named),
        _time(physics),
    ]  # fmt: skip
    head = ("", "goal", "measured", "interval", "trials", "truth made by")
    return markdown([head, ("---",) * len(head), *cells])


def wrong(lines: Sequence[Line]) -> str:
    """What was said instead of the truth, most frequent first."""
    counted = Counter(
        (line["row"], " + ".join(score.hidden(line)) or "nothing", _said(line))
        for line in lines
        if not score.right(line)
    )
    if not counted:
        return "Nothing."
    head = ("row", "hidden", "said", "times")
    found = [(*key, str(count)) for key, count in counted.most_common()]
    return markdown([head, ("---",) * len(head), *found])


def _said(line: Line) -> str:
    return f"{' + '.join(line['named']) or 'nothing'} ({line['verdict']})"


def _names(lines: Iterable[Line]) -> list[str]:
    return list(dict.fromkeys(line["row"] for line in lines))


def _counted(
    what: str, goal: str, lines: Sequence[Line], test: Callable[[Line], bool]
) -> tuple[str, ...]:
    return (what, goal, *percent(score.share(lines, test)), _makers(lines, test))


def _makers(lines: Sequence[Line], test: Callable[[Line], bool]) -> str:
    """Hits of trials for each maker of the truth."""
    parts = []
    for maker, name in MADE_BY.items():
        mine = [line for line in lines if line["facts"]["truth"] == maker]
        if mine:
            parts.append(f"{name} {score.share(mine, test).hits} of {len(mine)}")
    return ", ".join(parts)


def _parameters(
    what: str, goal: str, lines: Sequence[Line], test: Callable[..., bool]
) -> tuple[str, ...]:
    """A share of parameters; the last cell says how many carry no sigma."""
    known = [numbers for _, *numbers in score.parameters(lines)]
    hits = sum(test(*numbers) for numbers in known)
    silent = sum(numbers[2] is None for numbers in known)
    measured, interval, count = percent(Share(hits, len(known)))
    return what, goal, measured, interval, f"{count} parameters", f"{silent} without a sigma"


def _lawful(line: Line) -> bool:
    return bool(line["law_closes"] >= WANTED_CLOSED)


def _within_two(truth: float, value: float, sigma: float | None) -> bool:
    return sigma is not None and abs(value - truth) <= 2.0 * sigma


def _over_floor(lines: Sequence[Line]) -> tuple[str, ...]:
    """The goal is asked of the rms over all trials: single ones scatter by chance."""
    what = "held-out error after the ladder, over the floor (rms over explained trials)"
    if not lines:
        return what, "<= 1.05", "-", "-", "0", ""
    ratios = np.array([line["over_floor"] for line in lines])
    below = Share(int(np.sum(ratios <= WANTED_OVER_FLOOR)), ratios.size)
    return (
        what,
        "<= 1.05",
        f"{math.sqrt(float(np.mean(ratios**2))):.3f}",
        f"95 % below {np.quantile(ratios, 0.95):.3f}",
        str(ratios.size),
        f"{100 * below.hits / below.count:.1f} % of them <= 1.05",
    )


def _time(lines: Sequence[Line]) -> tuple[str, ...]:
    what = "processor time of a diagnosis, one thread"
    if not lines:
        return what, "", "-", "-", "0", ""
    seconds = np.array([line["cpu_s"] for line in lines])
    return (
        what,
        "",
        f"{np.median(seconds):.1f} s",
        f"95 % below {np.quantile(seconds, 0.95):.0f} s",
        str(seconds.size),
        f"longest {seconds.max():.0f} s",
    )
