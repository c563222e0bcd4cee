"""Kill commands at random moments and look at what they leave behind.

Run as a script, it kills ``--count`` commands and lists the faults; the tests run some of them.
A fault is: an exit code that does not belong to the signal, an error of the program or a traceback,
a result that is neither the old one nor the new one, a temporary that SIGINT or SIGTERM leaves or
that is still there after the next run, a process that lives on, or an end that takes too long.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import io
import math
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
LINES: dict[str, list[str]] = {
    "excite": ["excite", "standard", "-o", "OUT/command.csv"],
    "simulate": ["simulate", "IN/short.toml", "-o", "OUT/rec"],
    "film": ["simulate", "IN/film.toml", "--video", "-o", "OUT/rec"],
    "track": ["track", "IN/filmed/video.mkv", "-o", "OUT/angle.csv", "--draw"],
    "import": ["import", "IN/log.csv", "-o", "OUT/rec"],
    "identify": ["identify", "IN/log.csv", "-o", "OUT/model.toml", "--json", "OUT/r.json"],
    "compare": ["compare", "IN/model.toml", "IN/log.csv", "--report", "OUT/r.html"],
    "diagnose": ["diagnose", "IN/log.csv", "--auto", "-o", "OUT/m.toml", "--json", "OUT/d.json"],
}
"""Commands to kill; IN is a folder of inputs, OUT an own folder of outputs."""
VARYING = (b" UTC</p", b'"seconds"', b"seconds =", b"servosight ")
"""What a line holds that no second run repeats."""
EARLIEST_S = 0.02
"""Before this the new process may still be a copy of this one, which takes the signal itself."""
STARTED_S = 0.15
"""Before this the interpreter itself may be at its start, where Python ends in its own way."""


@dataclass(frozen=True)
class Kill:
    """One command, the signal that ends it, and when [s]."""

    name: str
    number: signal.Signals
    after_s: float


@dataclass(frozen=True)
class Outcome:
    """What a killed command left: its faults, and how long it took to end [s]."""

    kill: Kill
    code: int
    took_s: float
    faults: tuple[str, ...]


def prepare(folder: Path, *, film: bool = True) -> None:
    """Write the inputs of the commands; without ``film`` not those of ``track``."""
    from servosight.app.main import main

    inputs = folder / "in"
    inputs.mkdir(parents=True)
    rows = (
        f"{t:.3f},{10 * math.sin(3 * t):.6f},{10 * math.sin(3 * t - 0.15):.6f}"
        for t in (0.02 * i for i in range(400))
    )
    (inputs / "log.csv").write_text("time_s,command_deg,angle_deg\n" + "\n".join(rows) + "\n")
    (inputs / "short.toml").write_text("duration_s = 2.0\n")
    camera = "[camera]\nwidth = 200\nheight = 160\nrate_hz = 60.0\n"
    (inputs / "film.toml").write_text(f"duration_s = 2.0\n{camera}")
    with contextlib.redirect_stdout(io.StringIO()):
        if film:
            line = ["simulate", str(inputs / "film.toml"), "--video", "-o", str(inputs / "filmed")]
            assert main(line) == 0
        card = ["-o", str(inputs / "model.toml")]
        assert main(["identify", str(inputs / "log.csv"), *card]) == 0


def reference(name: str, folder: Path) -> dict[str, str]:
    """The digests of what an undisturbed run of a command writes."""
    out = folder / f"reference-{name}"
    if not out.exists():
        out.mkdir()
        subprocess.run(_line(name, folder, out), check=True, capture_output=True)
    return digests(out)


@contextlib.contextmanager
def not_ignored() -> Iterator[None]:
    """What a script starts in the background, or nohup, ignores signals, as does all it starts."""
    heard = (*SIGNALS[:2], signal.SIGHUP)
    ignored = [number for number in heard if signal.getsignal(number) is signal.SIG_IGN]
    for number in ignored:
        signal.signal(number, signal.SIG_DFL)
    try:
        yield
    finally:
        for number in ignored:
            signal.signal(number, signal.SIG_IGN)


def kill_once(kill: Kill, folder: Path, limit_s: float) -> Outcome:
    """Start a command in an own folder, kill it, and look."""
    wanted = reference(kill.name, folder)
    out = Path(tempfile.mkdtemp(dir=folder, prefix="out-"))
    with not_ignored():
        process = subprocess.Popen(
            _line(kill.name, folder, out),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(kill.after_s)
    ended = process.poll() is not None
    began = time.perf_counter()
    if not ended:
        process.send_signal(kill.number)
    _, said = process.communicate(timeout=60)
    took_s = time.perf_counter() - began
    left = digests(out)
    code = process.returncode
    if code == -kill.number and left == wanted:  # the work was done: the interpreter's own end
        code = 0
    faults = list(_faults(kill, code, ended, took_s, limit_s, said.decode()))
    if _lives_on(process.pid):
        faults.append("a process lives on")
        os.killpg(process.pid, signal.SIGKILL)
    hidden = [name for name in left if name.startswith(".")]
    if hidden and kill.number != signal.SIGKILL:
        faults.append(f"left {hidden[0]}")
    faults += [
        f"{name} is half written"
        for name, digest in left.items()
        if name not in hidden and wanted.get(name) != digest
    ]
    faults += _next_run(out)
    shutil.rmtree(out)
    return Outcome(kill, process.returncode, took_s, tuple(faults))


def random_kills(count: int, seed: int, names: list[str], longest_s: float) -> Iterator[Kill]:
    """Commands, signals and moments by ``seed``; moments are denser near the start."""
    rng = random.Random(seed)
    for index in range(count):
        yield Kill(
            names[index % len(names)],
            SIGNALS[(index // len(names)) % len(SIGNALS)],
            EARLIEST_S + (longest_s - EARLIEST_S) * rng.random() ** 2,
        )


def digests(folder: Path) -> dict[str, str]:
    """Every file and empty folder below ``folder`` with the digest of what does not vary."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name = path.relative_to(folder).as_posix()
        if path.is_file():
            lines = path.read_bytes().splitlines(keepends=True)
            steady = b"".join(x for x in lines if not any(word in x for word in VARYING))
            found[name] = hashlib.sha256(steady).hexdigest()
        elif not any(path.iterdir()):
            found[name] = ""
    return found


def _faults(
    kill: Kill, code: int, ended: bool, took_s: float, limit_s: float, said: str
) -> Iterator[str]:
    allowed = {
        signal.SIGINT: {130, 0},
        signal.SIGTERM: {143, 0},
        signal.SIGKILL: {-signal.SIGKILL, 0},
    }[kill.number]
    early = kill.after_s < STARTED_S
    if early:  # Python's own end, before the program has begun
        allowed = allowed | {-kill.number, 1}
    if ended:
        allowed = {0}
    if code not in allowed:
        yield f"exit code {code}: {said[-300:]}"
    if took_s > limit_s and not ended:
        yield f"took {took_s:.2f} s to end"
    if not early and ("Traceback" in said or "error of the program" in said):
        yield f"said {said[-300:]}"


def _lives_on(group: int, patience_s: float = 5.0) -> bool:
    """True where a process of the group is still there after a while."""
    until = time.perf_counter() + patience_s
    while time.perf_counter() < until:
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return False
        time.sleep(0.02)
    return True


def _next_run(out: Path) -> list[str]:
    """The faults that another run in the same folder leaves."""
    from servosight.app.main import main

    with contextlib.redirect_stdout(io.StringIO()):
        code = main(["excite", "sine", "-o", str(out / "next.csv")])
    stale = [entry.name for entry in out.iterdir() if entry.name.startswith(".")]
    return [f"the next run ended with {code}"] * (code != 0) + [
        f"{name} is stale" for name in stale
    ]


def _line(name: str, folder: Path, out: Path) -> list[str]:
    words = [
        word.replace("IN/", f"{folder / 'in'}/").replace("OUT/", f"{out}/") for word in LINES[name]
    ]
    return [sys.executable, "-c", "from servosight.app.main import main; exit(main())", *words]


def main() -> int:
    """Kill commands and report; exit code 1 where there was a fault."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--longest", type=float, default=8.0, help="latest moment [s]")
    parser.add_argument("--limit", type=float, default=2.0, help="longest time to end [s]")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        prepare(folder)
        outcomes = []
        for kill in random_kills(args.count, args.seed, list(LINES), args.longest):
            outcome = kill_once(kill, folder, args.limit)
            outcomes.append(outcome)
            for fault in outcome.faults:
                print(
                    f"{kill.name} {kill.number.name} at {kill.after_s:.3f} s: {fault}", flush=True
                )
    faulty = sum(bool(outcome.faults) for outcome in outcomes)
    slowest = max(outcome.took_s for outcome in outcomes)
    cut = sum(outcome.code != 0 for outcome in outcomes)
    print(f"{len(outcomes)} kills, {cut} before the end; {faulty} with faults")
    print(f"the slowest took {slowest:.2f} s to end")
    return 1 if faulty else 0


if __name__ == "__main__":
    sys.exit(main())
