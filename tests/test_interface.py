"""``import servosight as ss``: what it loads and offers, and the script that users start from."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import pytest
from matplotlib.figure import Figure
from threadpoolctl import threadpool_info, threadpool_limits

import servosight as ss
from servosight.models.effects import catalogue
from servosight.models.plant import Plant, Stimulus
from servosight.tracking.core import TrackOptions

LOADED = 40
"""More modules than these few of the standard library would mean that something heavy crept in."""


def outside(code: str) -> str:
    """What ``code`` prints in an interpreter of its own."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.strip()


def test_importing_it_loads_next_to_nothing() -> None:
    code = (
        "import sys; before = set(sys.modules); import servosight; "
        "new = set(sys.modules) - before; "
        "print(len(new), sorted(n for n in new if n.startswith('servosight')), "
        "[n for n in new if n.split('.')[0] in ('numpy', 'numba', 'cv2', 'mujoco', 'scipy')])"
    )
    count, rest = outside(code).split(" ", 1)
    assert int(count) <= LOADED
    assert rest == "['servosight'] []"


def test_reading_a_result_loads_no_compiler_and_no_engine() -> None:
    code = (
        "import sys, servosight as ss; ss.InputError, ss.Recording, ss.Actuator; "
        "print([n for n in ('numba', 'cv2', 'mujoco', 'matplotlib') if n in sys.modules])"
    )
    assert outside(code) == "[]"


def test_the_stub_names_what_there_is(project_root: Path) -> None:
    tree = ast.parse((project_root / "src/servosight/__init__.pyi").read_text())
    (named,) = (node.value for node in tree.body if isinstance(node, ast.Assign))
    assert sorted(ast.literal_eval(named)) == dir(ss)
    for name in dir(ss):
        assert getattr(ss, name) is not None
    with pytest.raises(AttributeError, match="nonsense"):
        getattr(ss, "nonsense")  # noqa: B009, mypy knows that there is none


@pytest.mark.parametrize("name", sorted(set(dir(ss)) - {"__version__"}))
def test_each_name_has_an_example(name: str) -> None:
    assert ">>> " in (getattr(ss, name).__doc__ or "")


def test_a_sub_package_does_not_take_a_verbs_place() -> None:
    code = (
        "import servosight as ss, servosight.identify.fit, servosight.diagnose; "
        "print(ss.identify.__module__, ss.diagnose.__module__)"
    )
    assert outside(code) == "servosight._verbs._models servosight._verbs._models"


def recorded(gap: float, seed: int, rate_hz: float = 60.0) -> ss.Recording:
    """Six seconds of steps and a triangle, seen through a play of ``gap``."""
    plant = Plant.of(catalogue())
    rows = np.arange(0.0, 6.0, 0.01)
    steps = 12.0 * np.sign(np.sin(2.0 * np.pi * 0.9 * rows))
    command = np.where(rows < 3.0, 15.0 * np.arcsin(np.sin(2.0 * np.pi * 0.7 * rows)), steps)
    time_s = np.arange(0.05, 6.0, 1.0 / rate_hz)
    quiet = ss.Recording("quiet", rows, command, time_s, np.zeros(time_s.size))
    row = np.array(plant.layout.neutral_row())
    row[:3] = 1.0, 0.03, 0.6
    row[plant.index("backlash.gap")] = gap
    noise = 0.02 * np.random.default_rng(seed).standard_normal(time_s.size)
    return ss.Recording.from_arrays(
        time_s=time_s,
        angle_deg=plant.simulate(row, Stimulus.of(quiet)) + noise,
        command_deg=command,
        command_time_s=rows,
        sigma_deg=np.full(time_s.size, 0.02),
        name=f"run{seed}",
    )


def filmed(path: Path) -> None:
    """A second of a printed fin that swings by 12 deg."""
    rng = np.random.default_rng(5)
    bench, skin = (
        cv2.GaussianBlur(rng.normal(0.0, 1.0, (240, 320)), (0, 0), 1.5) for _ in range(2)
    )
    shape = np.zeros((240, 320))
    cv2.fillPoly(shape, [np.array([[80, 100], [260, 105], [260, 135], [80, 140]])], 1.0)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=60)
        stream.width, stream.height, stream.pix_fmt = 320, 240, "yuv420p"
        stream.options = {"crf": "8", "threads": "1"}
        for angle in 12.0 * np.sin(np.linspace(0.0, 9.0, 60)):
            turn = cv2.getRotationMatrix2D((110.0, 120.0), float(angle), 1.0)
            fin, mask = (cv2.warpAffine(one, turn, (320, 240)) for one in (skin, shape))
            light = (1.0 - mask) * (60.0 + 60.0 * bench) + mask * (170.0 + 120.0 * fin)
            image = np.clip(light + rng.normal(0.0, 1.5, light.shape), 0, 255).astype(np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="gray")))
        container.mux(stream.encode())


class Frame(dict[str, Any]):
    """What a recording needs of a data frame."""

    @property
    def columns(self) -> list[str]:
        return list(self)


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_arrays_and_frames_become_the_same_recording() -> None:
    made = recorded(1.0, 7)
    t = made.time_s
    u = np.interp(t, made.command_time_s, made.command_deg)
    one = ss.Recording.from_arrays(time_s=t, angle_deg=made.angle_deg, command_deg=u)
    frame = Frame({"t": 1e3 * t, "pos": np.radians(made.angle_deg), "goal": np.radians(u)})
    two = ss.Recording.from_frame(
        frame, time="t", angle="pos", command="goal", unit="rad", time_unit="ms"
    )
    np.testing.assert_allclose(one.angle_deg, two.angle_deg, atol=1e-12)
    np.testing.assert_allclose(one.command_deg, two.command_deg, atol=1e-12)
    np.testing.assert_allclose(one.time_s, two.time_s, atol=1e-12)


def test_one_sigma_is_that_of_all_samples() -> None:
    t = np.arange(0.0, 2.0, 0.01)
    made = ss.Recording.from_arrays(
        time_s=t, angle_deg=np.sin(t), command_deg=np.sin(t), sigma_deg=0.03
    )
    np.testing.assert_array_equal(made.sigma_deg, np.full(t.size, 0.03))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"angle_deg": [1.0, 2.0]}, "angle_deg has 2 values"),
        ({"time_s": "abc"}, "time_s is no array of numbers"),
        ({"command_deg": np.zeros((3, 3))}, "one dimension"),
        ({"hold": "cubic"}, "hold is 'cubic'"),
        ({"command_deg": np.zeros(200)}, "never moves"),
        ({"angle_deg": np.full(200, np.nan)}, "finite"),
    ],
)
def test_arrays_that_are_no_recording_are_refused(change: dict[str, Any], words: str) -> None:
    t = np.arange(0.0, 2.0, 0.01)
    given: dict[str, Any] = {"time_s": t, "angle_deg": np.sin(t), "command_deg": np.sin(t)}
    with pytest.raises(ss.InputError, match=words):
        ss.Recording.from_arrays(**{**given, **change})


def test_a_frame_without_the_column_is_refused() -> None:
    with pytest.raises(ss.InputError, match="no column 'pos'"):
        ss.Recording.from_frame(Frame({"t": [1.0], "goal": [1.0]}), time="t", angle="pos")


def test_an_actuator_predicts_and_becomes_a_transfer_function(place: Path) -> None:
    Path("model.toml").write_text(
        "format = 1\neffects = []\n[parameters]\nk = 0.9\nT = 0.03\nxi = 0.6\nbias = 0.5\n"
    )
    act = ss.load("model.toml")
    t = np.arange(0.0, 1.0, 0.002)
    u = np.where(t < 0.1, 0.0, 10.0)
    angle = act.predict(time_s=t, command_deg=u)
    assert angle[0] == pytest.approx(0.5)
    assert angle[-1] == pytest.approx(9.5, abs=1e-6)
    system = act.to_control()
    assert float(system.dcgain()) == pytest.approx(0.9)
    peak = 0.9 * 10.0 * np.exp(-np.pi * 0.6 / np.sqrt(1.0 - 0.36))
    assert angle.max() - 9.5 == pytest.approx(peak, rel=1e-3)  # Ogata, 5th ed., eq. 5-21
    for given in ({}, {"time_s": t}, {"time_s": t, "command_deg": u[:-1]}):
        with pytest.raises(ss.InputError, match="predict"):
            act.predict(**given)
    act.save("again.toml")
    assert ss.load("again.toml").parameters == act.parameters
    assert repr(act) == "<Actuator: k 0.9000, T 0.03000, xi 0.6000, bias 0.5000; linear>"
    assert act.to_dict()["parameters"]["k"] == {"value": 0.9, "unit": "-"}
    assert list(act.to_frame()["value"]) == [0.9, 0.03, 0.6, 0.5]
    (line,) = act.plot(ax=Figure().subplots()).lines
    frequency_hz, gain_db = (np.asarray(one) for one in line.get_data())
    expected = np.abs(system(2j * np.pi * frequency_hz)).ravel()
    np.testing.assert_allclose(gain_db, 20.0 * np.log10(expected), atol=1e-9)


def test_a_recording_as_plain_values() -> None:
    made = recorded(1.0, 7)
    table = json.loads(json.dumps(made.to_dict()))
    assert table.pop("name") == made.name
    again = ss.Recording.from_arrays(
        **{key: value for key, value in table.items() if value is not None}
    )
    np.testing.assert_array_equal(again.angle_deg, made.angle_deg)
    np.testing.assert_array_equal(again.command_at(again.time_s), made.command_at(made.time_s))


def test_tracking_takes_all_options_of_the_tracker() -> None:
    options = {field.name for field in dataclasses.fields(TrackOptions)}
    assert set(inspect.signature(ss.track).parameters) == {"source", "progress"} | options


def test_a_fit_draws_angle_model_and_residual(place: Path) -> None:
    made = recorded(1.0, 7)
    fit = ss.identify(made, ["backlash"], method="gradient")
    upper = fit.plot(ax=Figure().subplots())
    (below,) = (one for one in upper.figure.axes if one is not upper)
    measured, model = (np.asarray(line.get_ydata()) for line in upper.lines)
    (residual,) = (np.asarray(line.get_ydata()) for line in below.lines)
    np.testing.assert_array_equal(measured, made.angle_deg)
    np.testing.assert_allclose(residual, measured - model, atol=1e-12)
    assert np.sqrt(np.mean(residual**2)) == pytest.approx(fit.rmse_deg, rel=1e-3)
    assert len(fit.plot_correlations(ax=Figure().subplots()).texts) == 16
    fit.save("fit.json")
    again = ss.load("fit.json")
    assert again == fit
    with pytest.raises(ss.InputError, match="does not say where its recordings are"):
        again.plot()
    assert len(again.plot(ax=Figure().subplots(), recordings=made).lines) == 2
    with pytest.raises(ss.InputError, match="expected one of the fit's"):
        fit.plot(number=1)


def test_what_was_in_memory_is_plotted_and_reported(place: Path) -> None:
    made = recorded(1.0, 7)
    compared = ss.compare(ss.identify(made, method="gradient"), made)
    upper = compared.plot(ax=Figure().subplots())
    marks = [patch for patch in upper.patches if patch.get_alpha() is None]
    assert len(marks) == len(compared.where) > 0
    compared.report("report.html")
    assert "run7" in Path("report.html").read_text(encoding="utf-8")
    made.save("again")
    ss.compare(compared, "again").save("compared.json")
    ss.load("compared.json").report("from_file.html")
    assert Path("from_file.html").exists()
    assert len(made.plot(ax=Figure().subplots()).lines) == 2
    assert "<caption>Recording run7" in made._repr_html_()


def test_what_is_no_result_is_not_loaded(place: Path) -> None:
    Path("other.json").write_text('{"type": "car"}')
    with pytest.raises(ss.InputError, match=r"other\.json: key type is 'car'"):
        ss.load("other.json")
    with pytest.raises(ss.InputError, match="no such file"):
        ss.load("missing.json")


@pytest.mark.slow
def test_the_script_that_users_start_from(place: Path, project_root: Path) -> None:
    """docs/python.md's script, run as printed on small recordings."""
    made, other = recorded(1.0, 7), recorded(1.0, 8)
    made.save(place / "run7")
    other.save(place / "run8")
    filmed(place / "fin.mp4")
    Path("command.csv").write_text("time_s,command_deg\n0.0,0.0\n0.5,5.0\n1.5,0.0\n")
    logged = recorded(1.0, 9, rate_hz=100.0)  # a log has command and angle at one time
    t, y, u = logged.time_s, logged.angle_deg, logged.command_at(logged.time_s)
    rows = np.column_stack([1e3 * t, y, u])
    np.savetxt("log.csv", rows, delimiter=",", header="t,pos,goal", comments="")
    text = (project_root / "docs" / "python.md").read_text(encoding="utf-8")
    script = text.split("```python\n")[1].split("```")[0]
    frame = Frame({"t": t, "pos": np.radians(y), "goal": np.radians(u)})
    space: dict[str, Any] = {"t": t, "y": y, "u": u, "frame": frame, "ax": Figure().subplots()}
    exec(compile(script, "docs/python.md", "exec"), space)
    assert np.ptp(space["track"].angle_deg) == pytest.approx(24.0, abs=0.5)
    assert space["why"].effects == ("backlash",)
    assert space["fit"].parameters["backlash.gap"].value == pytest.approx(1.0, abs=0.05)
    assert ss.load("diagnosis.json") == space["why"]
    assert "backlash" in Path("report.html").read_text(encoding="utf-8")
    assert space["sim"].truth["effects"] == ["backlash"]


def test_linear_algebra_has_one_thread_while_a_verb_works() -> None:
    """As on the command line, whose answers a second thread would round otherwise; the threads that
    there were before come back."""

    def threads() -> set[int]:
        pools = threadpool_info()
        return {pool["num_threads"] for pool in pools if pool["user_api"] == "blas"}

    seen: list[set[int]] = []
    with threadpool_limits(limits=2, user_api="blas"):
        before = threads()
        ss.diagnose(recorded(1.0, 1), auto=False, progress=lambda *_: seen.append(threads()))
        assert threads() == before
    assert before == {2}
    assert seen
    assert all(one == {1} for one in seen)
