"""What rows say: tables, and from which size an effect is found."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import polars as pl
import pytest

from servosight.scenarios.sweeps import summary
from servosight.scenarios.sweeps.answers import detection, share_at
from servosight.scenarios.sweeps.run import Facts


def test_the_size_and_its_interval_hold_what_they_say() -> None:
    """Recordings drawn from a known function: the 95 % interval holds its size 95 times of 100.

    Of 60 draws 57 +- 1.7 are expected; 52 and more is within three of these deviations.
    """
    rng = np.random.default_rng(0)
    sizes = np.geomspace(0.05, 2.0, 8)
    true, slope = 0.4, 4.0
    share = 1.0 / (1.0 + np.exp(-(slope * np.log(sizes / true) + math.log(19.0))))
    held = 0
    for _ in range(60):
        found = detection(sizes, rng.binomial(20, share), [20] * 8)
        assert found.size is not None
        held += (found.low or 0.0) <= true <= (found.high or math.inf)
    assert held >= 52


@pytest.mark.parametrize(
    ("found", "sentence"),
    [
        ([0, 0, 20, 20], "smallest play found in 95 % of recordings: 0.31 deg (0.24 to 0.41)"),
        (
            [20, 20, 20, 20],
            "smallest play found in 95 % of recordings: 0.1 deg (below 0.1 to 0.12)",
        ),
        ([0, 0, 0, 0], "no play up to 0.8 deg is found in 95 % of recordings"),
        ([0, 1, 4, 8], "no play up to 0.8 deg is found in 95 % of recordings"),
    ],
)
def test_the_answer_is_a_sentence(found: list[int], sentence: str) -> None:
    assert detection([0.1, 0.2, 0.4, 0.8], found, [20] * 4).sentence("play", "deg") == sentence


def test_one_size_alone_gives_no_answer() -> None:
    assert detection([0.1], [20], [20]).size is None


def test_the_share_at_a_size_rises_with_it() -> None:
    found = detection([0.1, 0.2, 0.4, 0.8], [1, 8, 17, 20], [20] * 4)
    assert found.size is not None
    assert share_at(found.size, found) == pytest.approx(0.95)
    shares = [share_at(size, found) or 0.0 for size in (0.1, 0.2, 0.4, 0.8)]
    assert shares == sorted(shares)
    assert shares[1] == pytest.approx(0.4, abs=0.15)
    assert share_at(1e-320, found) == pytest.approx(0.0, abs=1e-9)


def rows() -> pl.DataFrame:
    """Two cameras; the good one finds a play from 0.2 deg, the other from 0.8 deg."""
    made: list[dict[str, Any]] = []
    for noise in (0.01, 0.1):
        for gap in (0.1, 0.2, 0.4, 0.8):
            for seed in range(10):
                seen = gap >= (0.2 if noise < 0.05 else 0.8)
                made.append(
                    {
                        "noise_deg": noise, "effects.backlash.gap": gap, "seed": seed,
                        "status": "done", "error": None, "k_error": noise * (-1) ** seed,
                        "k_bound": noise, "effects": ["backlash"] if seen else ["dead_zone"],
                        "named": seen, "seconds": 1.0,
                    }
                )  # fmt: skip
    made.append({**made[0], "seed": 10, "status": "failed", "error": "ValueError: 3 is bad"})
    return pl.DataFrame(made)


def facts(cells: int = 81) -> Facts:
    axes = ("noise_deg", "effects.backlash.gap")
    return Facts(name="s", about="", made="m", axes=axes, cells=cells)


def test_a_table_by_axis_and_an_answer_for_each_camera() -> None:
    found = summary(rows(), facts())
    assert len(found.table) == 8
    first = found.table[0]
    assert (first["cells"], first["failed"]) == (11, 1)
    assert first["k_error"] == pytest.approx(0.01)
    assert first["k_bound"] == pytest.approx(0.01)
    assert found.kinds == {"ValueError: # is bad": 1}
    assert found.headline == "s: 81 cells over noise_deg, effects.backlash.gap, 1 failed"
    good, poor = found.found
    assert good.sentence.startswith("noise_deg 0.01: smallest backlash gap found in 95 %")
    assert good.detection.size is not None
    assert 0.1 < good.detection.size < 0.2
    assert poor.detection.size is not None
    assert 0.4 < poor.detection.size < 0.8
    assert summary(rows(), facts(cells=100)).headline.endswith("1 failed, 19 still to run")
