"""Random cases: damaged files, full disks, and command lines of odd words."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from fuzz.mutations import NUMBERS, mutated
from fuzz.targets import TARGETS

from servosight.models.effects import catalogue

OPTIONS = {
    "simulate": ("--effect", "--set", "--seed", "-o"),
    "import": ("-o", "--map", "--unit", "--unit-scale", "--deg-per-us", "--neutral-us"),
    "track": (
        *("--pivot", "--template", "--tip", "--at", "--pick", "--camera", "--light", "--marker"),
        *("--id", "-o", "--sheet"),
    ),
    "identify": ("--effects", "--method", "--seed", "-o", "--json", "--plugin", "--deg-per-us"),
    "compare": ("--json", "--report", "--plugin", "--neutral-us", "--effects", "--fix"),
    "diagnose": ("--validate", "--tolerance", "--limits", "--next", "--json", "--seed", "-o"),
    "add": ("-o", "--json", "--plugin"),
    "effects": ("--json", "--plugin"),
    "excite": (
        *(
            "--check",
            "--analyse",
            "-o",
            "--angle",
            "--rate",
            "--duration",
            "--centre",
            "--row-rate",
        ),
        *("--frequency", "--low", "--high", "--dwell", "--model", "--for", "--frame-rate"),
        *("--noise", "--json"),
    ),
    "bench": (
        *("-o", "--servo", "--camera", "--arm", "--yes", "--exposure", "--readout", "--stamp"),
        *("--low", "--high", "--neutral", "--rate", "--acceleration", "--longest", "--kind"),
    ),
    "calibrate": ("--board", "--columns", "--rows", "--square-mm", "--plane", "--print", "-o"),
    "predict": ("-o",),
    "export": ("--to", "--on", "--sample-time", "--transform", "--stiffness", "-o", "--json"),
    "report": ("-o",),
    "sweep": ("-o", "--workers", "--scheduler", "--retry"),
    "results": ("--json", "--plot"),
    "advise": ("--effect", "--size", "--results", "--json"),
}


# Not `rehearse`: a rehearsal takes more than a minute.
ACTIONS = (
    *("cameras", "servos", "check", "zero", "run", "auto", "wizard", "target", "firmware"),
    *("run", "check", "jump"),
)
ADDRESSES = (
    *("maestro:/dev/null?channel=0", "dynamixel:none?id=300", "board:x?neutral_us=nan"),
    *("feetech:/dev/null?baud=3", "servo:x", "maestro:", "board:/dev/null?period_ms=20"),
    *("v4l2:/dev/null?width=1", "v4l2:/dev/null", "genicam:x.cti?serial=", "genicam:log.csv"),
    *("picamera2:9?gain=x", "picamera2:0", "http://127.0.0.1:1/", "http://[", "rtsp://127.0.0.1:1"),
    *("clip.mkv", "film/video.mkv", "none.mkv", "v4l2:?exposure=nan", "http://:99999/?a=b"),
)
PLACES = (
    *("log.csv", "rec", "model.toml", "scenario.toml", "camera.toml", "command.csv", "plugin.py"),
    *(
        "bam.json",
        "log.json",
        "set",
        "clip.mkv",
        "nothing",
        "new.out",
        ".",
        "",
        "a\0b",
        "x" * 300,
        "y/" * 2500,
        "-",
    ),
    *(
        "/dev/null",
        "/proc/self/mem",
        "/proc/new.json",
        "\udcff.csv",
        "a\nb",
        "log.csv/x",
        "--",
        "~",
    ),
)
WORDS = (
    *("backlash", "dead_time,backlash", "backlash.gap=1", "backlash.gap=1e308", "k=nan", "T=-1"),
    *(
        "gradient",
        "csv",
        "control",
        "zoh",
        "ga",
        "sine",
        "steps",
        "chirp",
        "multisine",
        "prbs",
        "triangle",
        "1,2",
        "1,2,3,4",
    ),
    *("20,1e308", "nan,1", "1,", "aruco", "checkerboard", "time=t", "angle=pos:rad", "T,xi", "deg"),
)
FEW = ("backlash", "coulomb_friction", "dead_time")
"""What a diagnosis of the undamaged log may choose from: it is run often, and always the same."""


@dataclass(frozen=True)
class Case:
    """A command line and, where one is damaged, a file with what it holds."""

    line: tuple[str, ...]
    file: str | None = None
    data: bytes = b""
    largest_file: int | None = None

    def __str__(self) -> str:
        """As a reader repeats it."""
        damaged = f", {self.file} = {self.data!r}" if self.file else ""
        limit = "" if self.largest_file is None else f", disk full after {self.largest_file} bytes"
        return f"servosight {' '.join(map(repr, self.line))}{damaged}{limit}"


def cases(count: int, seed: int, folder: Path) -> Iterator[Case]:
    """``count`` cases by ``seed``; ``folder`` holds the valid inputs."""
    rng = random.Random(seed)
    weights = [target.weight for target in TARGETS]
    for _ in range(count):
        chance = rng.random()
        if chance < 0.25:
            yield _odd_line(rng)
            continue
        target = rng.choices(TARGETS, weights)[0]
        data = (folder / target.file).read_bytes()
        line = tuple(rng.choice(target.lines).split())
        if chance < 0.30:  # nothing is damaged but the disk is full
            line = (*line, "--json", "r.json") if line[0] in ("compare", "identify") else line
            yield Case(line, largest_file=rng.choice((0, 1, 100, 4000)))
            continue
        yield Case(line, target.file, mutated(rng, data, target.kinds))


def _odd_line(rng: random.Random) -> Case:
    """A command with random options and odd values; none that takes long."""
    command = rng.choice(list(OPTIONS))
    words = [command]
    firsts = {"simulate": "scenario.toml", "effects": "backlash", "excite": "sine"}
    if command == "bench":
        words.append(rng.choice(ACTIONS))
        words += rng.choices(("command.csv", "rec/command.csv", "log.csv"), k=rng.randint(0, 1))
    elif rng.random() < 0.7:
        words.append(firsts.get(command, "log.csv"))
    words += rng.choices(PLACES + WORDS, k=rng.randint(0, 2))
    for _ in range(rng.randint(0, 4)):
        words.append(rng.choice(OPTIONS[command]))
        if rng.random() < 0.9:
            devices = words[-1] in ("--servo", "--camera") and rng.random() < 0.7
            words.append(rng.choice(ADDRESSES if devices else PLACES + WORDS + NUMBERS))
    if command == "diagnose":
        words += [word for name in catalogue() if name not in FEW for word in ("--without", name)]
    return Case(tuple(words))
