"""The C of a model: no warning, no fault under the sanitizers, the kernel's angles to 1e-9 deg."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.shown import CORE, shown

from servosight.export.core import ExportRequest, ExportTrial
from servosight.export.csource import (
    compile_c,
    held_steps,
    kernel_angle,
    layout_of,
    missing,
    model_source,
)
from servosight.models.core import Actuator, Array, Estimate, InputError, Parameter, Recording
from servosight.models.effects import Effect, Place, catalogue

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")

HERE = Path(__file__).parent
PERIOD_S, SAMPLES = 0.004, 15000
WARNINGS = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"]


def actuator(effects: Sequence[str]) -> Actuator:
    values = CORE | {name: value for one in effects for name, value in shown(one).items()}
    return Actuator({name: Estimate(v, None, "") for name, v in values.items()}, tuple(effects))


def request(effects: Sequence[str]) -> ExportRequest:
    return ExportRequest(actuator=actuator(effects), catalogue=catalogue(), name="fin")


def minute() -> Array:
    """Steps, a chirp with noise and triangles, (samples,)."""
    t = PERIOD_S * np.arange(SAMPLES)
    noise = np.random.default_rng(3).normal(0.0, 0.2, SAMPLES)
    steps = 20.0 * np.sign(np.sin(2.0 * np.pi * 0.31 * t))
    chirp = 15.0 * np.sin(2.0 * np.pi * (0.1 + 0.05 * t) * t) + noise
    triangles = 30.0 * np.abs((0.4 * t) % 2.0 - 1.0)
    return np.select([t < 20.0, t < 45.0], [steps, chirp], triangles)


def test_every_effect_and_all_together_are_the_kernels(tmp_path: Path) -> None:
    """A minute at 250 Hz under the address and undefined behaviour sanitizers."""
    every = request(list(catalogue()))
    source = tmp_path / "main.c"
    drive = (HERE / "drive.c").read_text(encoding="utf-8")
    source.write_text("#include <stdlib.h>\n" + model_source(every) + drive, encoding="utf-8")
    program = str(tmp_path / "main")
    sanitizers = "-fsanitize=address,undefined,float-cast-overflow"
    compile_c(
        [*WARNINGS, "-g", sanitizers, "-fno-sanitize-recover", "-o", program, str(source), "-lm"]
    )
    sets = [[], *([name] for name in catalogue()), list(catalogue())]
    command = minute()
    layout = layout_of(every)
    names, rows = layout.names(), []
    for effects in sets:
        row = dict(zip(names, layout.neutral_row(), strict=True))
        row |= {name: one.value for name, one in actuator(effects).parameters.items()}
        row["initial_angle"] = CORE["k"] * float(command[0]) + CORE["bias"]
        row["initial_speed"] = 0.0
        rows.append([row[name] for name in names])
    given = command.tobytes() + np.array(rows).tobytes()
    done = subprocess.run(
        [program, str(SAMPLES), repr(PERIOD_S)], input=given, capture_output=True, check=False
    )
    assert done.returncode == 0, done.stderr[:2000]
    found = np.frombuffer(done.stdout).reshape(len(sets), SAMPLES + 1)
    times = np.concatenate([[0.0], np.cumsum(np.full(SAMPLES, PERIOD_S))])
    held = Recording("minute", times[:-1], command, times, np.zeros(times.size))
    trial = ExportTrial(recording=held, start_deg=rows[0][4])
    for effects, angle in zip(sets, found, strict=True):
        truth = kernel_angle(request(effects), trial, held_steps(trial))
        assert np.ptp(truth) > 20.0
        assert np.max(np.abs(truth - angle)) <= 1e-9, effects


@pytest.mark.parametrize("name", ["", "supply_sag"])
def test_a_model_of_its_own_compiles_without_a_warning(name: str, tmp_path: Path) -> None:
    """A card's own effects leave functions and branches out."""
    source = tmp_path / "fin.c"
    text = model_source(request([name] if name else []))
    source.write_text(text, encoding="utf-8")
    compile_c([*WARNINGS, "-c", "-o", str(tmp_path / "fin.o"), str(source)])
    for word in ("malloc", "calloc", "printf", "fopen", "stdio"):
        assert word not in text


def test_parameters_change_between_steps_and_bad_ones_are_refused(tmp_path: Path) -> None:
    """Also one whose effect was neutral: the play begins from where the surface is."""
    source, program = tmp_path / "main.c", tmp_path / "main"
    main = """#include <stdio.h>
    int main(void) {
        fin_model a, b;
        fin_defaults(&a);
        printf("%d ", fin_set(&a, FIN_BACKLASH_GAP, -1.0));
        printf("%d ", fin_set(&a, FIN_PARAMETERS, 0.0));
        printf("%d ", fin_set(&a, FIN_K, NAN));
        printf("%d ", fin_step(&a, NAN, 0.01));
        printf("%d ", fin_step(&a, 1.0, 0.0));
        fin_set(&a, FIN_BACKLASH_GAP, 0.0);
        fin_start(&a, 0.4, 0.0);
        for (int i = 0; i < 500; ++i) fin_step(&a, 10.0, 0.002);
        printf("%.6f ", fin_angle(&a));
        fin_set(&a, FIN_BACKLASH_GAP, 2.0);
        b = a;
        for (int i = 0; i < 500; ++i) { fin_step(&a, 10.5, 0.002); fin_step(&b, 14.0, 0.002); }
        printf("%.6f %.6f ", fin_angle(&a), fin_angle(&b));
        for (int i = 0; i < 2000; ++i) fin_step(&a, 10.5, 1.0);
        printf("%.6f ", fin_angle(&a));
        fin_start(&b, 0.0, 0.0);
        int full = 0;
        for (int i = 0; i < 5000 && !full; ++i) full = fin_step(&b, i % 2, 1e-6);
        printf("%d", full);
        return 0;
    }
    """
    both = request(["dead_time", "backlash"])
    source.write_text(model_source(both) + main, encoding="utf-8")
    compile_c(["-o", str(program), str(source), "-lm"])
    said = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout.split()
    assert said[:5] == ["1"] * 5
    first, inside, pushed, later = map(float, said[5:9])
    assert first == pytest.approx(9.9, abs=1e-4)
    assert inside == pytest.approx(9.9, abs=1e-4), "0.475 deg of motor travel is inside the play"
    assert pushed == pytest.approx(0.95 * 14.0 + 0.4 - 1.0, abs=0.5)
    assert later == inside
    assert said[9] == "2", "a full delay line is a status"


def raised(theta: float, w: float, share: float) -> float:
    """A load that takes what C has no like of."""
    return share * sum((theta, w))


def test_an_effect_that_c_cannot_say_is_named() -> None:
    words = dict.fromkeys(
        ("equation", "looks_like", "cause", "confirm", "remedy", "source"), "a test's own"
    )
    odd = Effect(
        id="odd",
        place=Place.LOAD,
        parameters=(Parameter("share", "-", 0.0, 1.0, 0.0),),
        starts=lambda features: ((0.1,),),
        term=raised,
        **words,
    )
    base = request([])
    values = dict(base.actuator.parameters) | {"odd.share": Estimate(0.1, None, "")}
    model = Actuator(values, ("odd",))
    both = replace(base, actuator=model, catalogue=catalogue() | {"odd": odd})
    with pytest.raises(InputError, match=r"effect odd: term cannot be written as C, .* sum"):
        model_source(both)


def test_without_a_compiler_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.delenv("CC", raising=False)
    assert "apt install gcc" in str(missing())
    with pytest.raises(InputError, match="no C compiler was found, expected cc, gcc or clang"):
        compile_c([])
