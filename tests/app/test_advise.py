"""servosight advise: which camera shows an effect of a size."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from servosight.app.main import main
from servosight.models.core import InputError
from servosight.scenarios.sweeps import advise, saved_answers
from servosight.scenarios.sweeps.answers import Found, detection


def answer(noise: float, found: list[int]) -> Found:
    return Found(
        effect="backlash",
        axis="effects.backlash.gap",
        settings={"noise_deg": noise},
        what="backlash gap",
        unit="deg",
        detection=detection([0.1, 0.2, 0.4, 0.8], found, [20] * 4),
    )


ANSWERS = [answer(0.3, [0, 0, 0, 20]), answer(0.01, [0, 20, 20, 20]), answer(0.1, [0, 9, 18, 20])]


@pytest.mark.parametrize(
    ("size", "enough"),
    [(0.05, ["no", "no", "no"]), (0.4, ["yes", "perhaps", "no"]), (0.9, ["yes", "yes", "yes"])],
)
def test_a_size_is_held_against_each_cameras_interval(size: float, enough: list[str]) -> None:
    found = advise(ANSWERS, "backlash", size)
    assert [one.enough for one in found] == enough
    assert found[0].settings["noise_deg"] == 0.01
    with pytest.raises(InputError, match="did you mean backlash"):
        advise(ANSWERS, "baklash", size)


def test_the_results_that_come_with_the_program_answer(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["advise", "--size", "0.5", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)["answers"]
    assert len(found) == 3
    assert {one["enough"] for one in found} <= {"yes", "perhaps", "no"}
    assert main(["advise", "--effect", "backlash", "--size", "0.5"]) == 0
    assert "backlash gap of 0.5 deg, by" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--size", "0"], "above 0"),
        (["--size", "1", "--effect", "dead_time"], "did not look for it"),
        (["--size", "1", "--results", "other.json"], "holds no answers"),
    ],
)
def test_bad_input(
    words: list[str],
    expected: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("other.json").write_text("{}")
    assert main(["advise", *words]) == 2
    assert expected in capsys.readouterr().err


def test_a_summary_is_read_back(tmp_path: Path) -> None:
    from servosight.models.core import plain

    table: dict[str, Any] = {"axes": [], "found": plain(ANSWERS)}
    (tmp_path / "s.json").write_text(json.dumps(table))
    found, whole = saved_answers(tmp_path / "s.json")
    assert found == ANSWERS
    assert whole == table
