"""The report through write_report: what it tells, that it holds together, that it is safe."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from support.page import Page
from support.reports import NAME, written

from servosight.app.report import write_report
from servosight.app.report.story import Story
from servosight.diagnose import Comparison, Diagnosis, compare, judge, predictions
from servosight.models.core import InputError, Recording, Table, degrees, rounded, times, uncertain
from servosight.models.effects import catalogue


def test_a_diagnosis_tells_the_whole_story(found: Diagnosis, told: tuple[str, Page]) -> None:
    assert found.effects == ("backlash",)
    text, page = told
    effect = catalogue()["backlash"]
    first, last = (found.ladder[i].held_out_rmse_deg for i in (0, -1))
    for words in (
        "What was missing: backlash",
        degrees(first),
        degrees(last),
        degrees(found.floor_deg),
        effect.looks_like,
        effect.cause,
        effect.confirm,
        effect.remedy,
        found.next_experiment,
        "Where the linear model fails",
        "backlash.gap",
        "+ backlash",
        "Coulomb friction",
        "What could be missing",
        "The parts are blocks of 1 s",
        found.headline,
        found.summary,
    ):
        assert " ".join(words.split()) in page.text, words
    order = [
        page.ids.index(name)
        for name in (
            *("verdict", "ladder", "angle", "where", "candidates"),
            *("response", "residuals", "parameters", "method"),
        )
    ]
    assert order == sorted(order)
    assert "regimes" not in page.ids  # the blocks that are tested lie within the fitted data
    assert "picture" not in page.ids  # no video
    assert len(text) < 1_500_000


def test_the_page_stands_alone(told: tuple[str, Page]) -> None:
    text, page = told
    assert all(address.startswith(("#", "data:")) for address in page.addresses)
    assert not page.tags & {"link", "iframe", "img"}
    assert text.count("<script>") == text.count("<script") == 1
    assert "@import" not in text
    assert not re.search(r"url\((?!#)", text)
    assert len(page.ids) == len(set(page.ids))
    for address in page.addresses:
        assert address.startswith("data:") or address[1:] in page.ids
    for root in page.roots:
        assert root["role"] == "img"
        assert root["aria-label"]
    assert 'lang="en"' in text
    assert "viewport" in text


def test_names_are_shown_and_not_obeyed(told: tuple[str, Page]) -> None:
    text, page = told
    assert NAME not in text
    assert NAME in page.text


def test_the_same_result_gives_the_same_bytes(
    tmp_path: Path, found: Diagnosis, recording: Recording, told: tuple[str, Page]
) -> None:
    again, _ = written(tmp_path / "again.html", found, [recording])
    assert again == told[0]


@pytest.mark.usefixtures("unpainted")
def test_a_place_that_cannot_be_written(
    tmp_path: Path, found: Diagnosis, recording: Recording
) -> None:
    with pytest.raises(InputError, match="nowhere"):
        write_report(tmp_path / "nowhere" / "report.html", found, [recording])
    assert list(tmp_path.iterdir()) == []


def test_a_comparison_leaves_out_what_it_did_not_try(
    tmp_path: Path, compared: Comparison, recording: Recording
) -> None:
    _, page = written(tmp_path / "report.html", compared, [recording])
    assert "The model misses something" in page.text
    assert {"verdict", "angle", "where", "method"} <= set(page.ids)
    assert not {"candidates", "ladder", "parameters"} & set(page.ids)
    assert "held out" not in page.text.lower().split("how it was measured")[0]


def test_a_model_without_any_error(tmp_path: Path, found: Diagnosis, recording: Recording) -> None:
    """Nothing divides by an error or a floor of zero."""
    (judged,) = predictions(found, [recording])
    simulated = replace(recording, angle_deg=judged.predicted_deg)
    exact = replace(
        found.ladder[-1], train_rmse_deg=0.0, validation_rmse_deg=0.0, held_out_rmse_deg=0.0
    )
    ladder = Table((found.ladder[0], exact))
    perfect = replace(found, noise_deg=0.0, floor_deg=0.0, tolerance_deg=0.0, ladder=ladder)
    _, page = written(tmp_path / "report.html", perfect, [simulated])
    assert " 0 deg" in page.text


def test_recordings_of_one_name(tmp_path: Path, compared: Comparison, recording: Recording) -> None:
    (one,) = judge(compared.actuator, [recording])
    calm = replace(recording, angle_deg=one.predicted_deg)
    twice = compare(compared.actuator, [calm, recording])
    assert Story.of(twice, [calm, recording], catalogue()).worst == 1
    _, page = written(tmp_path / "report.html", twice, [calm, recording])
    assert {"angle-0-figure_1", "angle-1-figure_1", "angle-1-close-figure_1"} <= set(page.ids)


def test_numbers_read_well() -> None:
    assert degrees(0.70171) == "0.702 deg"
    assert degrees(12.0) == "12.0 deg"
    assert rounded(-0.0) == "0"
    assert rounded(-1.234) == "−1.23"
    assert rounded(1.5e-12) == "1.50e−12"
    assert times(22.78) == "23"
    assert times(2438.0) == "2400"
    assert uncertain(2.00214, 0.0022) == ("2.0021", "0.0022")
    assert uncertain(153.2, 12.0) == ("153", "12")
    assert uncertain(0.5, None) == ("0.5000", "not known")
