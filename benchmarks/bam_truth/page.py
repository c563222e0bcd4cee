"""The page of results, from whatever lines there are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hidden.compound.facts import MATERIAL, OWN
from hidden.compound.score import at_floor, clean, complete, exact, foreign, material
from hidden.markdown import markdown, percent
from hidden.score import Share

from .trial import FRICTION

Line = Mapping[str, Any]

_TEXT = """# Servos of BAM's simulator

`python benchmarks/bam_truth --python VENV/bin/python`, then `--page`. The truth is the simulator
of `better-actuator-models` 1.0.2 (Duclusaud and Passault): its identified parameters of MX-64,
MX-106, XL-320 and XL330, its friction models M1 to M4, with and without a weight on an arm, in
steps of 0.5 ms. Goals go out at 50 Hz and arrive 4 ms late, the angle is read at 100 Hz with 0.03
deg of noise through the servo's encoder (`angle_of = "sensor"`). Two recordings of 8 s are fitted,
one chooses, one tests.

An effect is *material* where leaving it out, all else fitted anew without noise, adds
{material:g} noises to the misfit, or more; what adds less than half a noise must not be named; in
between either is right. Some take the place of one another when one is left out: directional
friction and load-dependent Stribeck friction, torque saturation and a current limit. The two
together are weighed as well: where only both are material, one must be named, and where only both
are not absent, either may be. A test error is judged against the floor of noise and of the true
effects' own misfit. *Within reach* of the catalogue are servos that the true effects fit within
{own:g} noises.

{table}

{trials}
"""


def friction_named(line: Line) -> bool:
    """True where every material friction is named and nothing foreign."""
    wanted = {name: names for name, names in material(line).items() if name in FRICTION}
    return clean(line) and all(set(line["named"]) & names for names in wanted.values())


def page(lines: Sequence[Line]) -> str:
    """The page in Markdown."""
    lines = sorted(lines, key=lambda line: line["seed"])
    near = [x for x in lines if x["facts"]["own_deg"] <= OWN * x["facts"]["noise_deg"]]
    rows = [("", "goal", "measured", "interval", "count"), ("---",) * 5]
    for words, mine in (("all servos", lines), ("those within reach", near)):
        for what, goal, test in (
            ("friction named and nothing foreign", "95 %", friction_named),
            ("every material effect named, nothing foreign", "", exact),
            ("every material effect named", "", complete),
            ("nothing foreign named", "", clean),
            ("test error within 1.1 of the floor", "90 %", at_floor),
        ):
            share = Share(sum(map(test, mine)), len(mine))
            rows.append((f"{words}: {what}", goal, *percent(share)))
    each = [("servo", "material", "named", "foreign", "floors", "own misfit"), ("---",) * 6]
    each += [_row(line) for line in lines]
    cost = np.median([line["cpu_s"] for line in lines]) if lines else 0.0
    return _TEXT.format(
        material=MATERIAL,
        own=OWN,
        table=markdown(rows),
        trials=f"A diagnosis took {cost:.0f} s of processor time (median).\n\n{markdown(each)}",
    )


def _row(line: Line) -> tuple[str, ...]:
    facts = line["facts"]
    weights = {**facts["weights"], **facts.get("together", {})}
    names = sorted(material(line), key=lambda name: -weights[name])
    return (
        line["name"],
        ", ".join(f"{name} {weights[name]:.0f}" for name in names) or "-",
        ", ".join(line["named"]) or "-",
        ", ".join(sorted(foreign(line))) or "-",
        f"{line['over_floor']:.2f}",
        f"{facts['own_deg'] / facts['noise_deg']:.2f}",
    )
