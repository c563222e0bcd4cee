"""What becomes of FMUs whose native code or whose archive is bad."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fuzz import fmus

from servosight.export.core import ExportRequest
from servosight.export.csource import compile_c, missing
from servosight.export.fmu import FMU2
from servosight.models.core import Actuator, Estimate, InputError
from servosight.models.effects import catalogue
from servosight.models.fmu import ArchiveLimits, FmuLimits, open_fmu, unpacked

pytestmark = pytest.mark.skipif(missing() is not None, reason="needs a C compiler")

VALUES = {"k": 0.9, "T": 0.03, "xi": 0.7, "bias": 0.0}

TIMES = np.arange(0.0, 2.0, 0.02)

BAD = """
#include <unistd.h>
int servo_step(servo_model *m, double command_deg, double duration_s)
{
    const int how = (int)m->p.v[0];
    (void)command_deg;
    (void)duration_s;
    if (how == 1) for (;;) { }
    if (how == 2) *(volatile int *)(size_t)how = how;
    if (how == 3) for (size_t n = 1 << 20;; n *= 2) { char *p = malloc(n); p[n - 1] = 1; }
    if (how == 5) for (int i = 3; i < 64; ++i) if (write(i, "FMU1 what?\\n\\n\\n\\n", 15)) { }
    if (how == 6) m->angle = NAN;
    return 0;
}
"""


@pytest.fixture(scope="module")
def bad(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An FMU that misbehaves as its gain says."""
    folder = tmp_path_factory.mktemp("bad")
    model = Actuator({name: Estimate(v, None, "") for name, v in VALUES.items()}, ())
    request = ExportRequest(actuator=model, catalogue=catalogue(), name="servo")
    FMU2.write(request, folder / "good.fmu")
    with zipfile.ZipFile(folder / "good.fmu") as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
        archive.extractall(folder)
    text = files["sources/model.c"].decode()
    _, declared, _ = text.partition("int servo_step(")
    begin = text.rindex(declared)
    end = text.index("\n}\n", begin) + 3
    text = text[:begin] + BAD + text[end:]
    text = text.replace("#include <math.h>", "#include <math.h>\n#include <stdlib.h>")
    (folder / "sources/model.c").write_text(text, encoding="utf-8")
    binary = next(name for name in files if name.startswith("binaries/"))
    compile_c(["-D_GNU_SOURCE", "-O0", "-shared", "-fPIC", "-o", str(folder / "library"),
               str(folder / "sources/fmi2.c"), "-lm"])  # fmt: skip
    files[binary] = (folder / "library").read_bytes()
    with zipfile.ZipFile(folder / "bad.fmu", "w") as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return folder / "bad.fmu"


@pytest.mark.parametrize(
    ("gain", "said"),
    [
        (1, "it takes more than 2 s"),
        (2, "ended by SIGSEGV"),
        (3, "ended by SIGSEGV"),
        (5, "its answer is no such thing"),
        (6, "its output is not finite"),
    ],
)
def test_native_code_that_misbehaves_is_one_sentence(gain: int, said: str, bad: Path) -> None:
    """An endless step, a crash, memory without end, exit, writing to all files, no number."""
    begin = time.monotonic()
    limits = FmuLimits(run_s=2.0, memory_bytes=2 << 30)
    words = {"command_name": "command", "output_name": "angle"}
    with pytest.raises(InputError) as caught, open_fmu(bad, limits=limits) as fmu:
        fmu.run(TIMES, np.zeros(TIMES.size - 1), start={"k": gain}, **words)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)
    assert time.monotonic() - begin < 60.0


def test_no_process_is_left_where_the_program_is_killed(bad: Path) -> None:
    """Within an endless step."""
    program = (
        "import numpy as np; from pathlib import Path; from servosight.models.fmu import open_fmu\n"
        f"with open_fmu(Path({str(bad)!r})) as fmu:\n"
        "    print(fmu.process.child.pid, flush=True)\n"
        "    fmu.run(np.arange(3.0), np.zeros(2), command_name='command', output_name='angle',\n"
        "            start={'k': 1.0})\n"
    )
    words = [sys.executable, "-c", program]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        child = int(parent.stdout.readline())
        time.sleep(0.3)
        parent.kill()
    until = time.monotonic() + 30.0
    while Path(f"/proc/{child}").exists() and time.monotonic() < until:
        time.sleep(0.05)
    assert not Path(f"/proc/{child}").exists()


def test_the_folder_of_a_killed_program_is_removed_at_the_next_start(
    good: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And not that of a running one, nor anything that only bears such a name."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr(tempfile, "tempdir", None)
    program = (
        "import time; from pathlib import Path; from servosight.models.fmu import unpacked\n"
        f"with unpacked(Path({str(good)!r})) as folder:\n"
        "    print(folder, flush=True)\n"
        "    time.sleep(60.0)\n"
    )
    words = [sys.executable, "-c", program]
    (tmp_path / "servosight-fmu-new").mkdir()
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdout is not None
        left = Path(parent.stdout.readline().strip()).parent
        with unpacked(good) as running:
            assert left.is_dir()
            parent.kill()
            parent.wait()
            with unpacked(good):
                assert not left.exists()
                assert running.is_dir()
    assert [one.name for one in tmp_path.glob("servosight-fmu-*")] == ["servosight-fmu-new"]


def test_a_folder_that_is_just_being_made_is_not_removed_by_another_start(
    good: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The other one starts where this one is about to lock its folder."""
    fcntl = pytest.importorskip("fcntl")
    real, begun = fcntl.flock, []

    def raced(lock: int, how: int) -> None:
        if how == fcntl.LOCK_EX and not begun:
            begun.append(True)
            with unpacked(good):
                pass
        real(lock, how)

    monkeypatch.setattr(fcntl, "flock", raced)
    with unpacked(good) as folder:
        assert (folder / "modelDescription.xml").is_file()
    assert begun


def test_damaged_archives_are_refused_before_anything_is_loaded(good: Path, tmp_path: Path) -> None:
    """Also where each limit begins."""
    kinds = ("named", "linked", "bomb")
    valid, rng = good.read_bytes(), np.random.default_rng(1)
    place = tmp_path / "damaged.fmu"
    for _ in range(12):
        for kind in kinds:
            place.write_bytes(fmus.KINDS[kind](valid, rng))
            with pytest.raises(InputError, match=r"damaged\.fmu: .*expected"), unpacked(place):
                pass
    with unpacked(good) as folder:
        size = sum(one.stat().st_size for one in folder.rglob("*") if one.is_file())
        count = sum(one.is_file() for one in folder.rglob("*"))
    for limits in (
        {"file_bytes": len(valid) - 1},
        {"entries": count - 1},
        {"total_bytes": size - 1},
        {"entry_bytes": 1000},
        {"description_bytes": 100},
        {"ratio": 1.5, "small": 100},
        {"name_length": 10},
    ):
        with pytest.raises(InputError), unpacked(good, ArchiveLimits(**limits)):
            pass
    exact = ArchiveLimits(file_bytes=len(valid), entries=count, total_bytes=size)
    with unpacked(good, exact):
        pass


def test_the_mutator_s_first_of_each_kind(good: Path, tmp_path: Path) -> None:
    """`make fuzz-fmu` runs 500; each ends in one sentence, which `tried` asserts."""
    valid, recording = good.read_bytes(), fmus.steps(tmp_path)
    targets = {
        "cut": "compare", "directory": "predict", "library": "identify", "described": "diagnose",
    }  # fmt: skip
    for name, data in fmus.mutants(valid, 10, seed=2):
        if name in targets:
            assert fmus.tried(data, targets[name], recording, tmp_path)
