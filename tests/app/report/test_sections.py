"""The report's sections on dynamics, correlation and film, its contents, and a report from JSON."""

from __future__ import annotations

import base64
import re
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from support.drawn_film import filmed

import servosight as ss
from servosight.app.main import main
from servosight.app.report import write_report
from servosight.diagnose import Diagnosis
from servosight.models.core import Estimate, Recording, Signals, Table, degrees, uncertain
from servosight.models.effects import catalogue
from servosight.models.plant import Plant, Stimulus, bandwidth_hz

KNOWN = ("backlash", "coulomb_friction")
OTHERS = [name for name in catalogue() if name not in KNOWN]
RATE_HZ = 60.0
K, T, XI, GAP = 1.0, 0.03, 0.5, 0.5


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """Six seconds of steps and a triangle, seen through a play, saved with a film of it."""
    plant = Plant.of(catalogue())
    rows = np.arange(0.0, 6.0, 0.01)
    steps = 12.0 * np.sign(np.sin(2.0 * np.pi * 0.7 * rows))
    command = np.where(rows < 3.0, 15.0 * np.arcsin(np.sin(2.0 * np.pi * 0.6 * rows)), steps)
    time_s = np.arange(0.05, 6.0, 1.0 / RATE_HZ)
    quiet = Recording("run", rows, command, time_s, np.zeros(time_s.size))
    row = np.array(plant.layout.neutral_row())
    row[:3] = K, T, XI
    row[plant.index("backlash.gap")] = GAP
    noise = 0.02 * np.random.default_rng(4).standard_normal(time_s.size)
    angle = plant.simulate(row, Stimulus.of(quiet)) + noise
    made = replace(quiet, angle_deg=angle, sigma_deg=np.full(time_s.size, 0.02))
    folder = tmp_path_factory.mktemp("report") / "run"
    made.save(folder)
    return filmed(made, folder, RATE_HZ)


@pytest.fixture(scope="module")
def found(recording: Recording) -> Diagnosis:
    """Of two effects to choose from, which takes a moment."""
    return ss.diagnose(recording, without_effects=OTHERS)


@pytest.fixture(scope="module")
def page(found: Diagnosis, recording: Recording, tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("page") / "report.html"
    at = datetime(2026, 3, 4, 5, 6, tzinfo=UTC)
    write_report(path, found, [recording], at=at, command="servosight diagnose run <x>")
    return path.read_text(encoding="utf-8")


def section(page: str, name: str) -> str:
    """The words of one section, without its figures and tags."""
    body = page.split(f'<section id="{name}">')[1].split("</section>")[0]
    body = re.sub(r"<svg.*?</svg>", " ", body, flags=re.DOTALL)
    return " ".join(re.sub(r"<[^>]+>", " ", body).split())


@pytest.mark.usefixtures("unpainted")
def test_residuals_name_the_samples_that_are_tested(
    page: str, recording: Recording, found: Diagnosis, tmp_path: Path
) -> None:
    """A test of 1 s is too short for 0.5 s of lags; a comparison fits nothing and tests all."""
    assert "Validation and test samples. The bands" in section(page, "residuals")
    path = tmp_path / "report.html"
    write_report(path, ss.compare(found.actuator, recording), [recording])
    assert "All samples. The bands" in section(path.read_text(encoding="utf-8"), "residuals")
    other = replace(recording, angle_deg=recording.angle_deg + 1e-3)
    whole = ss.diagnose(
        recording, test=other, with_effects=KNOWN[:1], without_effects=OTHERS, auto=False
    )
    write_report(path, whole, [recording, other])
    assert "Test samples. The bands" in section(path.read_text(encoding="utf-8"), "residuals")


@pytest.mark.usefixtures("unpainted")
def test_the_step_is_the_one_that_the_figures_are_of(recording: Recording, tmp_path: Path) -> None:
    """A test run moves twice as far as the fitted one, by a quarter of whose range is stepped."""
    far = replace(
        recording,
        command_deg=2.0 * recording.command_deg,
        angle_deg=2.0 * recording.angle_deg,
    )
    found = ss.diagnose(recording, test=far, without_effects=OTHERS, auto=False)
    path = tmp_path / "report.html"
    write_report(path, found, [recording, far])
    size = degrees(0.25 * float(np.ptp(recording.command_deg)))
    assert f"after a step of the command by {size}." in section(
        path.read_text(encoding="utf-8"), "dynamics"
    )


def test_dynamics_carry_a_sigma(page: str, found: Diagnosis) -> None:
    """Bode figures and step metrics of the last model, as saved, and as they really are."""
    assert found.effects == ("backlash",)
    last = found.ladder[-1].dynamics
    assert last is not None
    words = section(page, "dynamics")
    for name, factor, unit in (
        ("natural_frequency_hz", 1.0, "Hz"),
        ("bandwidth_hz", 1.0, "Hz"),
        ("rise_time_s", 1e3, "ms"),
        ("settling_time_s", 1e3, "ms"),
        ("overshoot", 100.0, "%"),
        ("final_change_deg", 1.0, "deg"),
    ):
        one = getattr(last, name)
        assert isinstance(one, Estimate)
        assert one.sigma is not None
        value, sigma = uncertain(factor * one.value, factor * one.sigma)
        assert f"{value} ± {sigma} {unit}" in words, name
    bandwidth = last.bandwidth_hz
    assert bandwidth.sigma is not None
    assert abs(bandwidth.value - bandwidth_hz(T, XI)) < 4.0 * bandwidth.sigma
    assert "Bode plot of the linear core" in page


def test_correlations_are_shown(page: str, found: Diagnosis) -> None:
    matrix = found.ladder[-1].correlation
    assert matrix is not None
    words = section(page, "parameters")
    at = matrix.names.index("T"), matrix.names.index("xi")
    shown = f"{matrix.values[at]:+.2f}".replace("-", "−")
    assert "ξ = " in words
    assert all(f"{place} {name}" in words for place, name in enumerate(matrix.names, 1))
    assert "correlation" in words.lower()
    assert shown in words


@pytest.mark.usefixtures("unpainted")
def test_errors_that_all_samples_share_are_told_apart(
    tmp_path: Path, found: Diagnosis, recording: Recording, page: str
) -> None:
    """The table is by noise; one sentence names whose variance is the clocks' or calibration's."""
    assert "What all samples share" not in page
    last = found.ladder[-1]
    assert last.correlation is not None
    clocks = replace(last.correlation, values=np.ones_like(last.correlation.values))
    shares = {"k": 0.5, "T": 0.999, "xi": 0.876, "backlash.gap": 0.6}
    step = replace(last, correlation=clocks, shared_error=shares)
    changed = replace(found, ladder=Table([*found.ladder[:-1], step]))
    write_report(tmp_path / "report.html", changed, [recording])
    words = section((tmp_path / "report.html").read_text(encoding="utf-8"), "parameters")
    assert "of the variance of T 100 %, xi 88 % and backlash.gap 60 %." in words
    assert "+1.00" not in words


def test_the_worst_seconds_are_a_film(page: str) -> None:
    data = re.search(r'<video[^>]*src="data:video/mp4;base64,([^"]+)"', page)
    assert data is not None
    assert re.search(r'<video[^>]*poster="data:image/jpeg;base64,', page)
    assert base64.b64decode(data[1])[4:8] == b"ftyp"
    assert "slow motion" in section(page, "film") or "frames" in section(page, "film")


def test_contents_date_and_command(page: str) -> None:
    contents = page.split('aria-label="Contents"')[1].split("</nav>")[0]
    linked = re.findall(r'href="#([\w-]+)"', contents)
    sections = re.findall(r'<section id="([\w-]+)"', page)
    assert linked == sections[1:]
    assert {"dynamics", "film", "parameters", "method"} <= set(linked)
    assert "4 March 2026, 05:06 UTC" in page
    assert "<code>servosight diagnose run &lt;x&gt;</code>" in page


def test_figures_can_be_enlarged(page: str) -> None:
    script = page.split("<script>")[1].split("</script>")[0]
    assert "figure" in script
    assert "click" in script
    assert "Enter" in script
    assert page.count("<figure") >= 6


@pytest.mark.usefixtures("unpainted")
def test_a_report_of_a_model_card_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    card = tmp_path / "model.toml"
    ss.Actuator({name: Estimate(1.0, None, "") for name in ("k", "T", "xi", "bias")}).save(card)
    words = ["report", str(card), "-o", str(tmp_path / "one.html")]
    assert main(words) == 2
    error = capsys.readouterr().err
    assert "model.toml: holds no diagnosis and no comparison, expected the JSON of one" in error
    assert "--json diagnosis.json" in error


def test_a_report_from_saved_json(
    found: Diagnosis, recording: Recording, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It finds the recording where it was, or where it is said to be."""
    found.save(tmp_path / "diagnosis.json")
    words = ["report", str(tmp_path / "diagnosis.json")]
    assert main([*words, "-o", str(tmp_path / "one.html")]) == 0
    assert main([*words, str(recording.path), "-o", str(tmp_path / "two.html")]) == 0
    capsys.readouterr()
    one, two = ((tmp_path / name).read_text(encoding="utf-8") for name in ("one.html", "two.html"))
    assert found.headline in one
    assert section(one, "dynamics") == section(two, "dynamics")
    assert "servosight report" in one


def test_a_report_says_where_recordings_are_missing(
    found: Diagnosis, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    gone = replace(found, recordings=found.recordings.__class__())
    gone.save(tmp_path / "diagnosis.json")
    words = ["report", str(tmp_path / "diagnosis.json"), "-o", str(tmp_path / "one.html")]
    assert main(words) == 2
    assert "does not say where its recordings are" in capsys.readouterr().err


def test_recordings_that_were_moved_are_to_be_named(
    found: Diagnosis, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    moved = [replace(one, path=tmp_path / "before" / "run") for one in found.recordings]
    replace(found, recordings=found.recordings.__class__(moved)).save(tmp_path / "diagnosis.json")
    page = tmp_path / "one.html"
    assert main(["report", str(tmp_path / "diagnosis.json"), "-o", str(page)]) == 2
    assert f"diagnosis.json REC -o {page}`" in capsys.readouterr().err
    assert not page.exists()


def test_a_known_disturbance_is_drawn_below_the_error(
    found: Diagnosis, recording: Recording, page: str, tmp_path: Path
) -> None:
    pulses = np.where(recording.time_s % 2.0 < 0.5, 20.0, 0.0)
    pushed = replace(recording, signals=Signals(recording.time_s, {"disturbance_N": pulses}))
    path = tmp_path / "pushed.html"
    write_report(path, found, [pushed], at=datetime(2026, 3, 4, tzinfo=UTC), command="-")
    written = path.read_text(encoding="utf-8")
    assert "disturbance [N]" in written
    assert "the known disturbance drawn in the lowest panel" in section(written, "angle")
    assert "predicted from the command alone" in section(page, "angle")
    assert "disturbance [N]" not in page


@pytest.mark.usefixtures("unpainted")
def test_a_special_case_has_the_size_of_the_effect_that_contains_it(
    found: Diagnosis, recording: Recording, tmp_path: Path
) -> None:
    """Of a speed limit only the torque limit is certain: its size is the stall torque."""
    limit = {
        "speed_limit.stall": Estimate(4.321, 0.1, "deg"),
        "speed_limit.no_load_speed": Estimate(25e3, 16e3, "deg/s"),
    }
    *before, last = found.ladder
    ends = replace(
        last,
        effects=(*last.effects, "speed_limit"),
        parameters={**last.parameters, **limit},
        correlation=None,
        sampling_correlation=None,
    )
    named = replace(found, effects=("backlash", "torque_saturation"), ladder=Table((*before, ends)))
    write_report(tmp_path / "report.html", named, [recording])
    said = section((tmp_path / "report.html").read_text(encoding="utf-8"), "verdict")
    assert "What that means: torque saturation" in said
    assert "4.32" in said.split("What that means: torque saturation")[1]
