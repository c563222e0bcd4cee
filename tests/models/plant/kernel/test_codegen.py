"""One kernel for a registry: written once, cached by its text, the same physics for any choice."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from servosight.models.core import InputError, Parameter
from servosight.models.effects import Effect, GuessFeatures, Place, catalogue
from servosight.models.plant import Layout, Plant, Stimulus
from servosight.models.plant.kernel import kernel, kernel_source
from servosight.models.plant.kernel._codegen import cache_folder

STIMULUS = Stimulus(
    np.array([0.0, 0.05, 0.2]),
    np.array([0.0, 20.0, -7.0]),
    False,
    np.arange(0.0, 0.4, 0.0013),
    np.ones(1),
)


def spring(theta: float, w: float, cubic: float) -> float:
    """A load that hardens."""
    return cubic * theta * theta * theta


def lagged(drive: float, w: float, state: float, share: float) -> tuple[float, float]:
    """A drive that sags by a share of its own filtered size, with 10 ms of memory."""
    return drive * (1.0 - share * state), (abs(drive) - state) / 0.01


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    return ((0.01,),)


def reading(speed: float, drive: float, load: float, level: float) -> float:
    return level + 0.0 * speed


WORDS = dict.fromkeys(
    ("equation", "looks_like", "cause", "confirm", "remedy", "source"), "a test's own"
)
SPRING = Effect(
    id="spring",
    place=Place.LOAD,
    parameters=(Parameter("cubic", "deg/deg^3", -1.0, 1.0, 0.0),),
    starts=starts,
    term=spring,
    **WORDS,
)
READING = Effect(
    id="reading",
    place=Place.FRICTION,
    parameters=(Parameter("level", "deg", 0.0, 10.0, 0.0),),
    starts=starts,
    term=reading,
    **WORDS,
)
LAGGED = Effect(
    id="lagged",
    place=Place.DRIVE,
    parameters=(Parameter("share", "1/deg", 0.0, 1.0, 0.0),),
    starts=starts,
    term=lagged,
    states=1,
    **WORDS,
)
OWN = {one.id: one for one in (SPRING, LAGGED, READING)}
"""One registry for the tests that compile one: what a test does not use is neutral."""


def test_names_and_columns_of_a_row() -> None:
    layout = Layout.of(catalogue().values())
    names = layout.names()
    assert names[:6] == ["k", "T", "xi", "bias", "initial_angle", "initial_speed"]
    assert len(names) == len(set(names)) == layout.width == len(layout.neutral_row())
    for effect, offset in zip(layout.effects, layout.offsets, strict=True):
        assert names[offset] == f"{effect.id}.{effect.parameters[0].name}"


def test_the_text_is_the_same_each_time_and_holds_each_equation_once() -> None:
    text = kernel_source(catalogue().values())
    assert text == kernel_source(catalogue().values())
    for name, effect in catalogue().items():
        for role in effect.hooks:
            assert text.count(f"def {name}__{role}(") == 1


def test_a_kernel_of_the_users_own_effects_against_scipy() -> None:
    """A load and a drive with a state, neither in the catalogue; truth: scipy to 1e-10."""
    from scipy.integrate import solve_ivp

    plant = Plant.of(OWN)
    row = np.array(plant.layout.neutral_row())
    T, xi, cubic, share = 0.0078, 0.55, 4e-4, 0.01
    row[:3] = 1.0, T, xi
    plain = Plant.of(catalogue())
    neutral = np.array(plain.layout.neutral_row())
    neutral[:3] = row[:3]
    np.testing.assert_allclose(
        plant.simulate(row, STIMULUS), plain.simulate(neutral, STIMULUS), atol=1e-12
    )
    row[plant.index("spring.cubic")] = cubic
    row[plant.index("lagged.share")] = share
    x = np.zeros(3)
    truth = np.zeros(STIMULUS.samples_s.size)
    edges = [0.0, 0.05, 0.2, 0.5]
    for begin, end, u in zip(edges, edges[1:], STIMULUS.command_deg, strict=False):

        def rates(_: float, y: np.ndarray, u: float = u) -> list[float]:
            e = u - y[0]
            net = e * (1 - share * y[2]) - cubic * y[0] ** 3 - 2 * xi * T * y[1]
            return [y[1], net / T**2, (abs(e) - y[2]) / 0.01]

        answer = solve_ivp(
            rates, (begin, end), x, "DOP853", rtol=1e-10, atol=1e-11, dense_output=True
        )
        inside = (STIMULUS.samples_s >= begin) & (STIMULUS.samples_s <= end)
        truth[inside] = answer.sol(STIMULUS.samples_s[inside])[0]
        x = answer.y[:, -1]
    error = np.abs(plant.simulate(row, STIMULUS) - truth).max()
    print(f"{error:.1e} deg")
    assert error < 0.002


def test_a_linear_servo_is_exact_where_samples_lie_further_apart_than_the_step() -> None:
    plant = Plant.of(catalogue())
    few = replace(STIMULUS, samples_s=STIMULUS.samples_s[::16])
    row = np.array(plant.layout.neutral_row())
    row[:6] = 1.0, 0.0078, 0.55, 0.4, 3.0, 50.0
    # Rows are met to 1e-12 s, at up to 2000 deg/s.
    fine = plant.simulate(row, few, step_s=1e-5)
    np.testing.assert_allclose(plant.simulate(row, few), fine, rtol=0.0, atol=1e-8)


def test_columns_of_a_table_are_not_compiled_for_anew() -> None:
    """Strided, of whole numbers or read-only: the kernel knows one layout in memory."""
    plant = Plant.of(catalogue())
    row = np.array(plant.layout.neutral_row())
    table = np.column_stack([STIMULUS.time_s, STIMULUS.command_deg.astype(np.float32)])
    table.flags.writeable = False
    given = Stimulus(*table.T, False, np.arange(1, 3), np.ones(1))
    plant.simulate(row, STIMULUS)
    known = plant.run.signatures  # type: ignore[attr-defined]
    assert plant.simulate(row, given).shape == (2,)
    assert plant.run.signatures == known  # type: ignore[attr-defined]


def test_friction_that_reads_nothing_of_the_motion_gives_what_the_general_scheme_gives() -> None:
    """Coulomb's law as the catalogue has it, stepped exactly, and as one that reads the speed."""
    simple = Plant.of(catalogue())
    general = Plant.of(OWN)
    angles = []
    for plant, name in ((simple, "coulomb_friction.level"), (general, "reading.level")):
        row = np.array(plant.layout.neutral_row())
        row[:3], row[plant.index(name)] = (1.0, 0.0078, 0.55), 1.2
        angles.append(plant.simulate(row, STIMULUS))
    np.testing.assert_allclose(*angles, rtol=0.0, atol=1e-9)


def test_two_second_inertias_are_refused() -> None:
    shaft = catalogue()["flexible_shaft"]
    with pytest.raises(InputError, match="at most one second inertia"):
        kernel_source([shaft, replace(shaft, id="another_shaft")])


def test_an_equation_that_is_no_plain_function_is_refused() -> None:
    with pytest.raises(InputError, match="plain function"):
        kernel_source([replace(SPRING, term=lambda theta, w, cubic: cubic * theta)])


def test_the_cache_is_where_the_user_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SERVOSIGHT_CACHE", str(tmp_path / "kernels"))
    assert cache_folder() == tmp_path / "kernels"
    assert cache_folder().is_dir()
    monkeypatch.delenv("SERVOSIGHT_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder() == tmp_path / "xdg" / "servosight"


def test_a_compilation_is_announced_until_it_is_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("SERVOSIGHT_CACHE", str(tmp_path))
    effects = {"spring": SPRING}
    caplog.set_level("INFO", logger="servosight")
    said = "compiling the equations of 1 effects, once; this takes up to a minute"
    for _ in range(2):  # interrupted before anything was compiled, and begun again
        kernel(effects)
        assert caplog.messages == [said]
        (name,) = (path.stem for path in tmp_path.glob("*.py"))
        monkeypatch.delitem(sys.modules, name)
        caplog.clear()
    (tmp_path / "__pycache__").mkdir(exist_ok=True)
    (tmp_path / "__pycache__" / f"{name}.simulate_rows-1.py311.nbi").touch()
    kernel(effects)
    assert caplog.messages == []
    monkeypatch.delitem(sys.modules, name)


def test_a_second_process_finds_the_kernel_compiled() -> None:
    """The kernel of this process is on disk; another one starts without compiling it anew."""
    Plant.of(catalogue()).simulate(
        np.array(Layout.of(catalogue().values()).neutral_row()), STIMULUS
    )
    script = (
        "import numpy as np, sys\n"
        "from servosight.models.plant.warmup import main\n"
        "main()\n"
        "name = next(n for n in sys.modules if n.startswith('servosight_kernel'))\n"
        "stats = sys.modules[name].simulate_rows.stats\n"
        "assert sum(stats.cache_hits.values()) == 1, stats\n"
        "assert not stats.cache_misses, stats\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    ("name", "told", "kept"),
    [
        ("OMP_WAIT_POLICY", None, "passive"),
        ("OMP_WAIT_POLICY", "active", "active"),
        ("GOMP_SPINCOUNT", None, "1000"),
        ("GOMP_SPINCOUNT", "0", "0"),
    ],
)
def test_waiting_threads_soon_sleep_unless_told_otherwise(
    name: str, told: str | None, kept: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(name, told or "")
    if told is None:
        monkeypatch.delenv(name)
    kernel(catalogue())
    assert os.environ[name] == kept
