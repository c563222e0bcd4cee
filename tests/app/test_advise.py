"""servosight advise: which camera shows an effect of a size."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from servosight.app.main import main
from servosight.models.core import InputError, json_text
from servosight.scenarios.sweeps import SHIPPED, advise, saved_answers
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
        (["--size", "1", "--results", "other.json"], "other.json: Object missing required field"),
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
    whole = saved_answers(SHIPPED)
    (tmp_path / "s.json").write_text(json_text(whole))
    again = saved_answers(tmp_path / "s.json")
    assert again == whole
    assert again.found[0].detection.sizes


@pytest.mark.parametrize("text", ["{}", '{"found": 3}', '{"axes": [], "found": [1]}'])
def test_what_is_no_summary_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "s.json").write_text(text)
    with pytest.raises(InputError, match=r"s.json: .*servosight results --json"):
        saved_answers(tmp_path / "s.json")


def test_a_damaged_number_of_a_summary_is_refused(tmp_path: Path) -> None:
    text = json_text(saved_answers(SHIPPED))
    for name, value in (("share", "1.5"), ("share", "0"), ("size", "-2"), ("low", "0")):
        damaged = re.sub(rf'"{name}": [^,\n]*', f'"{name}": {value}', text)
        (tmp_path / "s.json").write_text(damaged)
        with pytest.raises(InputError, match=r"s.json: .*expected"):
            saved_answers(tmp_path / "s.json")
