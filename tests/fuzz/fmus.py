"""Damage to an FMU, from a seed: its archive, its description, its binary.

    make fuzz-fmu FMUS=500        # or python tests/fuzz/fmus.py [COUNT] [SEED]

writes a good FMU, damages it COUNT times (default 500) and gives each to every command that takes
an FMU. Each run must end in one sentence and exit code 2, or well where the damage does not matter.
"""

from __future__ import annotations

import contextlib
import io
import re
import stat
import sys
import tempfile
import zipfile
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

Files = dict[str, bytes]
DESCRIPTION = "modelDescription.xml"


def mutants(valid: bytes, count: int, seed: int) -> Iterator[tuple[str, bytes]]:
    """``count`` damaged copies with the name of the damage, all kinds in turn."""
    rng = np.random.default_rng(seed)
    kinds = list(KINDS)
    for i in range(count):
        name = kinds[i % len(kinds)]
        yield name, KINDS[name](valid, rng)


def _files(valid: bytes) -> Files:
    with zipfile.ZipFile(io.BytesIO(valid)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def _packed(files: Files, modes: dict[str, int] | None = None) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (modes or {}).get(name, 0o100644) << 16
            archive.writestr(entry, data)
    return out.getvalue()


def _binary(files: Files) -> str:
    return next(name for name in files if name.startswith("binaries/"))


def _cut(valid: bytes, rng: np.random.Generator) -> bytes:
    return valid[: int(rng.integers(0, len(valid)))]


def _flipped(valid: bytes, rng: np.random.Generator) -> bytes:
    data = bytearray(valid)
    for at in rng.integers(0, len(data), int(rng.integers(1, 40))):
        data[at] ^= int(rng.integers(1, 256))
    return bytes(data)


def _directory(valid: bytes, rng: np.random.Generator) -> bytes:
    data = bytearray(valid)
    first = valid.rindex(b"PK\x01\x02", 0, valid.index(b"PK\x01\x02") + 4)
    for at in rng.integers(first, len(data), int(rng.integers(1, 12))):
        data[at] = int(rng.integers(0, 256))
    return bytes(data)


def _named(valid: bytes, rng: np.random.Generator) -> bytes:
    names = (
        "../outside.txt", "/etc/outside", "a/../../outside", "C:/outside", "sources\\x.c",
        "..\\outside", "bin\x01ary", "a" * 2000, "modeldescription.XML", "sources/model.c/inside",
    )  # fmt: skip
    files = _files(valid)
    return _packed({**files, str(rng.choice(names)): b"x"})


def _linked(valid: bytes, rng: np.random.Generator) -> bytes:
    files = _files(valid)
    place = str(rng.choice(["link", "sources/link", "binaries/link"]))
    kind = int(rng.choice([stat.S_IFLNK, stat.S_IFIFO, stat.S_IFCHR]))
    return _packed({**files, place: b"/etc/passwd"}, {place: kind | 0o777})


def _bomb(valid: bytes, rng: np.random.Generator) -> bytes:
    return _packed({**_files(valid), "resources/zero": bytes(int(rng.integers(3, 30)) << 20)})


def _left_out(valid: bytes, rng: np.random.Generator) -> bytes:
    files = _files(valid)
    files.pop(str(rng.choice([DESCRIPTION, _binary(files)])))
    return _packed(files)


def _platform(valid: bytes, rng: np.random.Generator) -> bytes:
    files = _files(valid)
    old = _binary(files)
    other = str(rng.choice(["win64", "x86_64-windows", "riscv32-linux", "linux", ""]))
    files[f"binaries/{other}/{Path(old).name}"] = files.pop(old)
    return _packed(files)


def _library(valid: bytes, rng: np.random.Generator) -> bytes:
    files = _files(valid)
    name = _binary(files)
    data = bytearray(files[name])
    how = int(rng.integers(0, 4))
    if how == 0:
        data = data[: int(rng.integers(0, len(data)))]
    elif how == 1:
        data = bytearray(rng.bytes(len(data)))
    elif how == 2:
        data[: int(rng.integers(4, 4096))] = bytes(16)
    else:  # a function that importers need has another name
        data = bytearray(bytes(data).replace(b"DoStep\0", b"DoStop\0"))
    files[name] = bytes(data)
    return _packed(files)


def _described(valid: bytes, rng: np.random.Generator) -> bytes:
    files = _files(valid)
    text = files[DESCRIPTION].decode()
    changes: list[Callable[[str], str]] = [
        lambda t: t[: int(rng.integers(0, len(t)))],
        lambda t: re.sub(r'fmiVersion="[^"]*"', f'fmiVersion="{rng.choice(["1.0", "9", ""])}"', t),
        lambda t: re.sub(r'(guid|instantiationToken)="[^"]*"', r'\1="other"', t),
        lambda t: t.replace('causality="input"', 'causality="output"'),
        lambda t: t.replace('causality="output"', 'causality="local"'),
        lambda t: re.sub(r'name="\w+" valueReference', 'name="same" valueReference', t),
        lambda t: re.sub(r'start="[^"]*"', f'start="{rng.choice(["x", "", "1e999x"])}"', t),
        lambda t: re.sub(r"<CoSimulation.*", "", t),
        lambda t: re.sub(r'modelIdentifier="[^"]*"', 'modelIdentifier="../../other"', t),
        lambda t: re.sub(r'valueReference="[^"]*"', 'valueReference="99999999999999999999"', t),
        lambda t: t.replace(
            'canHandleVariableCommunicationStepSize="true"',
            f'fixedInternalStepSize="{rng.choice(["1e-300", "5e-324", "-1", "INF", "NaN"])}"'),
        lambda t: t.replace("<fmiModelDescription", "<nothing").replace("</fmi", "</nothing"),
        lambda t: '<!DOCTYPE x [<!ENTITY a "' + "b" * 999 + '"><!ENTITY c "'
        + "&a;" * 999 + '"><!ENTITY d "' + "&c;" * 999 + '">]>' + t.partition("?>")[2].replace(
            'description="', 'description="&d;', 1),
        lambda t: '<!DOCTYPE x SYSTEM "file:///etc/passwd">' + t.partition("?>")[2] + "\0",
    ]  # fmt: skip
    files[DESCRIPTION] = changes[int(rng.integers(0, len(changes)))](text).encode()
    return _packed(files)


KINDS: dict[str, Callable[[bytes, np.random.Generator], bytes]] = {
    "cut": _cut,
    "flipped": _flipped,
    "directory": _directory,
    "named": _named,
    "linked": _linked,
    "bomb": _bomb,
    "left out": _left_out,
    "platform": _platform,
    "library": _library,
    "described": _described,
}
"""By what is damaged."""


def good_fmu(folder: Path) -> Path:
    """A valid FMU of a linear model with a play."""
    from servosight.export.core import ExportRequest
    from servosight.export.fmu import FMU3
    from servosight.models.core import Actuator, Estimate
    from servosight.models.effects import catalogue

    values = {"k": 0.9, "T": 0.03, "xi": 0.7, "bias": 0.0, "backlash.gap": 0.5}
    model = Actuator({name: Estimate(v, None, "") for name, v in values.items()}, ("backlash",))
    request = ExportRequest(actuator=model, catalogue=catalogue(), name="servo")
    FMU3.write(request, folder / "good.fmu")
    return folder / "good.fmu"


def steps(folder: Path) -> Path:
    """A recording of two seconds of steps."""
    from servosight.models.core import Recording
    from servosight.models.io import save_recording

    time_s = np.arange(0.0, 2.0, 0.02)
    command = np.where(time_s % 1.0 < 0.5, 10.0, -10.0)
    save_recording(Recording("steps", time_s, command, time_s, 0.9 * command), folder / "steps")
    return folder / "steps"


def tried(data: bytes, target: str, recording: Path, folder: Path) -> str:
    """What the command ``target`` says of a damaged FMU: its one sentence, or "" where it ran."""
    from servosight.app.main import main as servosight

    place, made = folder / "damaged.fmu", folder / "angle.csv"
    place.write_bytes(data)
    made.unlink(missing_ok=True)
    words = TARGETS[target](str(place), str(recording), str(made))
    error = io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(error):
        code = servosight([*words, "--trust"])
    if code == 0:
        return ""
    lines = [line for line in error.getvalue().splitlines() if not line.startswith("note: ")]
    said = lines[-1] if lines else ""
    assert (code, len(lines)) == (2, 1), (code, lines)
    assert said.isprintable(), said
    assert str(place) in said, said
    assert len(said) < 700, said
    assert not made.exists(), said
    return said


TARGETS: dict[str, Callable[[str, str, str], list[str]]] = {
    "compare": lambda fmu, recording, _: ["compare", fmu, recording],
    "predict": lambda fmu, recording, made: ["predict", fmu, recording, "-o", made],
    "identify": lambda fmu, recording, _: ["identify", recording, "--model", fmu],
    "diagnose": lambda fmu, recording, _: ["diagnose", recording, "--from", fmu],
}
"""The commands that take an FMU: words from its file, a recording, and a file to write."""


def main(count: int = 500, seed: int = 20) -> int:
    """Damage and try; prints how many were refused, by kind, and one sentence of each."""
    refused: Counter[str] = Counter()
    ran: Counter[str] = Counter()
    shown: dict[str, str] = {}
    failed: list[str] = []
    with tempfile.TemporaryDirectory() as folder:
        valid, recording = good_fmu(Path(folder)).read_bytes(), steps(Path(folder))
        for i, (name, data) in enumerate(mutants(valid, count, seed)):
            for target in TARGETS:
                try:
                    said = tried(data, target, recording, Path(folder))
                except AssertionError as error:
                    failed.append(f"number {i} of seed {seed}, {name}, {target}: {error}")
                    continue
                (refused if said else ran)[name] += 1
                shown.setdefault(name, said)
    for name in KINDS:
        print(f"{name}: {refused[name]} refused, {ran[name]} ran; {shown.get(name, '')[-200:]}")
    print(
        f"{refused.total()} of {count * len(TARGETS)} runs ({', '.join(TARGETS)}) refused in one "
        f"sentence each, {ran.total()} ran, {len(failed)} failed"
    )
    print("\n".join(failed[:20]))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
