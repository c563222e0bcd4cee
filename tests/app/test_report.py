"""The report through write_report: what it tells, that it holds together, that it is safe."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from support.drawn_film import FIN, PIVOT, filmed
from support.page import Page

from servosight.app.report import write_report
from servosight.app.report.figure import POINTS, thinned
from servosight.app.report.sections.selection import ladder
from servosight.app.report.sections.selection.candidates import groups
from servosight.app.report.story import Story
from servosight.diagnose import (
    Comparison,
    Diagnosis,
    Verdict,
    compare,
    diagnose,
    judge,
    predictions,
)
from servosight.diagnose.evidence import Regime
from servosight.diagnose.experiment import Proposal, Separation
from servosight.diagnose.result.wording import Levels, verdict_words
from servosight.models.core import InputError, Recording, Table, degrees, rounded, times, uncertain
from servosight.models.effects import catalogue
from servosight.models.excitation import CommandLimits, design
from servosight.models.plant import Plant, Stimulus
from servosight.scenarios.produce import OURS
from servosight.sources import TRACK_FILE, geometry_of

GAP_DEG = 2.0
NOISE_DEG = 0.02
RATE_HZ = 60.0
DURATION_S = 9.0
NAME = "<b>run & $5$</b>"
"""A folder may be called that: the page must show it, not obey it."""


def recorded(gap: float, name: str = NAME) -> Recording:
    """A triangle and steps, seen through a play of ``gap``."""
    plant = Plant.of(catalogue())
    rows = np.arange(0.0, DURATION_S, 0.01)
    steps = 12.0 * np.sign(np.sin(2.0 * np.pi * 0.7 * rows))
    command = np.where(rows < 5.0, 15.0 * np.arcsin(np.sin(2.0 * np.pi * 0.6 * rows)), steps)
    time_s = np.arange(0.05, DURATION_S, 1.0 / RATE_HZ)
    quiet = Recording(name, rows, command, time_s, np.zeros(time_s.size))
    row = np.array(plant.layout.neutral_row())
    row[:3] = 1.0, 0.03, 0.6
    row[plant.index("backlash.gap")] = gap
    noise = NOISE_DEG * np.random.default_rng(4).standard_normal(time_s.size)
    angle = plant.simulate(row, Stimulus.of(quiet)) + noise
    return replace(quiet, angle_deg=angle, sigma_deg=np.full(time_s.size, NOISE_DEG))


@pytest.fixture(scope="module")
def recording() -> Recording:
    return recorded(GAP_DEG)


@pytest.fixture(scope="module")
def found(recording: Recording) -> Diagnosis:
    return diagnose([recording], catalogue=catalogue(), auto=True)


@pytest.fixture(scope="module")
def compared(recording: Recording, found: Diagnosis) -> Comparison:
    linear = replace(found, ladder=found.ladder[:1], effects=()).actuator
    return compare(linear, [recording])


def written(path: Path, result: Any, recordings: list[Recording]) -> tuple[str, Page]:
    write_report(path, result, recordings)
    text = path.read_text(encoding="utf-8")
    return text, Page(text)


@pytest.fixture(scope="module")
def told(
    found: Diagnosis, recording: Recording, tmp_path_factory: pytest.TempPathFactory
) -> tuple[str, Page]:
    """The diagnosis's report: its text, and read as a page."""
    return written(tmp_path_factory.mktemp("told") / "report.html", found, [recording])


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
        "coulomb friction",
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


@pytest.mark.usefixtures("unpainted")
def test_verdicts_in_words(tmp_path: Path, found: Diagnosis, recording: Recording) -> None:
    one, levels = found.ladder[:1], Levels(noise_deg=0.02, tolerance_deg=0.015, floor_deg=0.025)
    ranked = verdict_words(Verdict.UNEXPLAINED, one, found.candidates, None, levels)
    assert "backlash alone would help most" in ranked[1]
    assert "the floor of 0.0250° (noise 0.0200° and tolerance 0.0150° together)" in ranked[1]
    nothing = verdict_words(Verdict.NO_EFFECT_MISSING, one, found.candidates, None, levels)
    assert nothing[0] == "No effect is missing"
    close = replace(levels, floor_deg=0.5 * found.ladder[-1].held_out_rmse_deg)
    part = verdict_words(Verdict.UNEXPLAINED, found.ladder, found.candidates, None, close)
    assert part[0] == "Not fully explained"
    assert "something remains that no known effect accounts for" in part[1]
    held = replace(found.ladder[-1], held=("k held at 1 from here, 0.93 before",))
    steps = Table([*found.ladder[:-1], held])
    result = replace(
        found, verdict=Verdict.UNEXPLAINED, headline=part[0], summary=part[1], ladder=steps
    )
    _, page = written(tmp_path / "part.html", result, [recording])
    assert "+ backlash: k held at 1 from here, 0.93 before." in page.text
    assert part[0] in page.text
    assert " ".join(part[1].split()) in page.text
    assert "What the error of the model with backlash shows: " in page.text
    rivals = Table(replace(c, confounded_with=("dead_zone",)) for c in found.candidates[:1])
    doubt = replace(found, candidates=rivals, alternatives=(("dead_zone",), ("presliding",)))
    _, page = written(tmp_path / "doubt.html", doubt, [recording])
    said = "cannot distinguish backlash from dead zone; or from presliding: their predictions"
    assert page.text.count(said) == 2


@pytest.mark.usefixtures("unpainted")
def test_a_law_is_the_last_step_of_the_falling_error(found: Diagnosis) -> None:
    law: Any = SimpleNamespace(held_out_after_deg=0.05, floor_deg=0.03)
    for added_to, name in (((), "linear model + law"), (found.effects, "+ law")):
        law.added_to = added_to
        story: Any = SimpleNamespace(result=replace(found, law=law), floor_deg=0.03)
        shown = ladder.section(story)
        assert shown is not None
        names = [rung.name for rung, _ in shown.values["steps"]]
        assert names == ["linear model", "+ backlash", name]
        last, floors = shown.values["steps"][-1]
        assert (last.held_out_deg, last.validation_deg, last.explained) == (0.05, None, False)
        assert floors == pytest.approx(0.05 / 0.03)


@pytest.mark.usefixtures("unpainted")
def test_findings_are_told_as_they_are(
    tmp_path: Path,
    found: Diagnosis,
    compared: Comparison,
    recording: Recording,
    told: tuple[str, Page],
) -> None:
    """The page, the JSON and the sentences hold the same findings."""
    assert found.findings
    short = written(tmp_path / "report.html", compared, [recording])
    for result, (_, page) in ((found, told), (compared, short)):
        for one, entry in zip(result.findings, result.to_dict()["findings"], strict=True):
            assert " ".join(one.sentence.split()) in page.text
            assert set(entry) == {"test", "sentence", "size_deg", "share", "p"}
    assert compared.to_dict()["sentences"][1:] == [one.sentence for one in compared.findings]


def test_the_proposed_experiment_is_drawn(
    tmp_path: Path, found: Diagnosis, recording: Recording
) -> None:
    made = design("triangle", CommandLimits(15.0, None, 8.0))
    limits = CommandLimits(15.0, None, 8.0)
    pair = Separation(between=("backlash", "dead_zone"), log_likelihood=4.0, difference_deg=0.012)
    other = Separation(
        between=("backlash", "coulomb_friction"), log_likelihood=40.0, difference_deg=0.1
    )
    proposal = Proposal.of(made, limits, (pair, other), 0.02, 0.01)
    _, page = written(tmp_path / "report.html", replace(found, proposal=proposal), [recording])
    assert "experiment" in page.ids
    assert made.words in page.text
    assert "backlash or dead zone" in page.text
    assert "No command within these limits distinguishes all models" in page.text


@pytest.mark.usefixtures("unpainted")
def test_no_experiment_is_drawn_that_decides_nothing(
    tmp_path: Path, found: Diagnosis, recording: Recording
) -> None:
    limits = CommandLimits(15.0, None, 8.0)
    pair = Separation(between=("backlash", "dead_zone"), log_likelihood=4.0, difference_deg=0.012)
    undecided = Proposal.of(design("triangle", limits), limits, (pair,), 0.02, 0.01)
    for without in (None, undecided):
        _, page = written(tmp_path / "without.html", replace(found, proposal=without), [recording])
        assert "experiment" not in page.ids


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
    assert "0°" in page.text


def test_recordings_of_one_name(tmp_path: Path, compared: Comparison, recording: Recording) -> None:
    (one,) = judge(compared.actuator, [recording])
    calm = replace(recording, angle_deg=one.predicted_deg)
    twice = compare(compared.actuator, [calm, recording])
    assert Story.of(twice, [calm, recording], catalogue()).worst == 1
    _, page = written(tmp_path / "report.html", twice, [calm, recording])
    assert {"angle-0-figure_1", "angle-1-figure_1", "angle-1-close-figure_1"} <= set(page.ids)


@pytest.mark.usefixtures("unpainted")
def test_the_frame_shows_where_the_model_is_off(
    tmp_path: Path, found: Diagnosis, recording: Recording
) -> None:
    film = filmed(recording, tmp_path, RATE_HZ)
    text, page = written(tmp_path / "report.html", found, [film])
    assert "picture" in page.ids
    error = predictions(found, [film], 0)[0].error_deg
    worst = int(np.argmax(np.abs(error)))
    assert f"frame {worst} of" in page.text
    assert f"off by {degrees(abs(error[worst]))}" in page.text
    # The fin's tip is 150 px from its pivot: the outlines lie that far apart, to the smoothing.
    polygons = re.findall(r'<polygon class="(measured|before)" points="([^"]*)"', text)
    shapes = {kind: np.array([p.split(",") for p in v.split()], float) for kind, v in polygons}
    apart = np.hypot(*(shapes["measured"] - shapes["before"]).T).max()
    assert apart == pytest.approx(150.0 * 2.0 * np.sin(np.deg2rad(abs(error[worst])) / 2), rel=0.03)
    assert text.count("data:image/jpeg") == 2  # the whole picture, and what stands before the film
    assert text.count("data:image/png") == 1


def test_geometry_is_kept_only_while_it_fits(tmp_path: Path, recording: Recording) -> None:
    assert geometry_of(recording) is None
    assert TRACK_FILE in OURS  # a recording filmed anew replaces it
    film = filmed(recording, tmp_path, RATE_HZ)
    kept = geometry_of(film)
    assert kept is not None
    assert kept.pivot_px == PIVOT
    np.testing.assert_allclose(kept.outline_px[0], FIN[0], atol=0.01)
    fewer = replace(film, time_s=film.time_s[:-1], angle_deg=film.angle_deg[:-1])
    assert geometry_of(fewer) is None
    for text in ("format = 1", "junk [", 'pivot_px = "x"\noutline_px = 3'):
        (tmp_path / "track.toml").write_text(text)
        assert geometry_of(film) is None
    assert film.video is not None
    with film.video.open("ab") as stream:
        stream.write(b"more")
    filmed(recording, tmp_path, RATE_HZ)
    assert geometry_of(film) is not None
    with film.video.open("ab") as stream:
        stream.write(b"more")
    assert geometry_of(film) is None


def test_long_lines_keep_their_peaks() -> None:
    x = np.arange(100_000.0)
    line = np.sin(x / 5000.0)
    line[61_234] = 9.0
    ((kept_x, kept),) = thinned(x, line)
    assert kept.size <= 2 * POINTS
    assert kept.max() == 9.0
    assert np.all(np.diff(kept_x) > 0)
    short = thinned(x[:10], line[:10])[0][1]
    np.testing.assert_array_equal(short, line[:10])


def test_groups_that_cannot_be_told_apart_are_named_once() -> None:
    rivals = {"a": ("b",), "b": ("a",), "c": ()}
    candidates: Any = [SimpleNamespace(effect=k, confounded_with=v) for k, v in rivals.items()]
    assert groups(candidates) == [("a", "b")]


def test_numbers_read_well() -> None:
    assert degrees(0.70171) == "0.702°"
    assert degrees(12.0) == "12.0°"
    assert rounded(-0.0) == "0"
    assert rounded(-1.234) == "−1.23"
    assert rounded(1.5e-12) == "1.50e−12"
    assert times(22.78) == "23"
    assert times(2438.0) == "2400"
    assert uncertain(2.00214, 0.0022) == ("2.0021", "0.0022")
    assert uncertain(153.2, 12.0) == ("153", "12")
    assert uncertain(0.5, None) == ("0.5000", "not known")


@pytest.mark.usefixtures("unpainted")
def test_what_lies_beyond_the_fitted_data_and_what_could_not_have_shown(
    tmp_path: Path, found: Diagnosis, recording: Recording
) -> None:
    beyond = Regime(
        quantity="speed",
        unit="deg/s",
        fitted_low=0.0,
        fitted_high=50.0,
        beyond="above",
        limit=55.0,
        reached=218.0,
        share_samples=0.62,
        share_error=0.94,
        rmse_deg=1.08,
        recording="fast",
        use="test",
        leading=True,
        sentence="94 % of the squared error on fast lies at a speed above 55.0 deg/s",
        remedy="",
    )
    sizes = {one.effect: one for one in found.detectable}
    unseen = [replace(sizes["cogging"], value=None), sizes["dead_zone"]]
    shown = replace(found, regimes=Table([beyond]), detectable=Table(unseen))
    _, page = written(tmp_path / "beyond.html", shown, [recording])
    assert "regimes" in page.ids
    assert "Beyond the fitted data" in page.text
    assert "speed 50.0 deg/s 218 deg/s 62 % 94 % 1.08°" in page.text
    assert f"{beyond.sentence}." in page.text
    assert "could not have shown, whatever its size: cogging" in page.text
    assert "dead zone would have shown from" in page.text
