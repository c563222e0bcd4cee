"""Small valid inputs of every format, and the random damage that is done to them."""

from __future__ import annotations

import contextlib
import io
import json
import math
import random
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from fuzz.logs import write_logs
from fuzz.mutations import BYTES, NUMBERS, SETTINGS, TABLE, TEXT, Mutation, mutated

from servosight.models.effects import catalogue
from servosight.scenarios.sweeps import SHIPPED

PLUGIN = '''"""A term of one's own."""

from servosight.models.core import FIXED, Parameter
from servosight.models.effects import Effect, GuessFeatures, Place


def term(drive: float, w: float, ratio: float) -> float:
    return drive * (1.0 + ratio)


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    return ((0.1,),)


EFFECTS = (
    Effect(
        id="own_gain",
        place=Place.DRIVE,
        parameters=(Parameter("ratio", "-", 0.0, 1.0, 0.0, "more drive", FIXED),),
        equation="e = drive (1 + ratio)",
        looks_like="a stiffer servo",
        cause="none",
        confirm="none",
        remedy="none",
        source="none",
        starts=starts,
        term=term,
    ),
)
'''
CAMERA = """format = 1
width = 64
height = 48
rms_px = 0.1
quality = "good"

[lens]
focal_px = [60.0, 60.0]
principal_px = [32.0, 24.0]
distortion = [0.0, 0.0, 0.0, 0.0, 0.0]

[plane]
onto = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
"""
SCENARIO = """duration_s = 1.0
noise_deg = 0.02
seed = 3
video = false

[servo]
k = 1.0
T = 0.03
xi = 0.7

[motion]
kind = "standard"
amplitude_deg = 10.0

[effects.backlash]
gap = 0.5

[camera]
rate_hz = 120.0
exposure_s = 0.001
"""
SWEEP = """scenario = "scenario.toml"
seeds = 1
through = "angles"
do = ["identify"]

[axes]
noise_deg = [0.02]
"camera.rate_hz" = { from = 100, to = 120, steps = 2, scale = "log" }
"""
SETTINGS_TOML = """format = 1
hold = "linear"
video_offset_s = 0.0

[camera]
exposure_s = 0.001
readout_s = 0.0
"""
TRACK_TOML = """# Written by servosight: track
format = 1
frames = 60
left_out = [3]
video_bytes = 100
pivot_px = [10.0, 10.0]
outline_px = [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]]

[sha256]
"angle.csv" = "0"
"""


MESSAGES = "--map command=goal.data:deg --map angle=angle.data:deg"
JOINTS = "--map command=action[1]:deg --map angle=state[1]:deg"


@dataclass(frozen=True)
class Target:
    """A file to damage, how, and the commands that read it; ``weight`` is how often."""

    file: str
    kinds: tuple[Mutation, ...]
    lines: tuple[str, ...]
    weight: int


TARGETS = (
    Target("log.csv", TABLE, ("compare model.toml log.csv", "import log.csv -o new"), 14),
    Target("log.csv", TABLE, ("identify log.csv --method gradient",), 3),
    Target("log.csv", TABLE, ("diagnose log.csv",), 1),
    Target("rec/recording.toml", SETTINGS, ("compare model.toml rec", "excite --analyse rec"), 12),
    Target("rec/command.csv", TABLE, ("compare model.toml rec", "excite --analyse rec"), 12),
    Target(
        "rec/command.csv",
        TABLE,
        ("bench run rec/command.csv -o new --servo maestro:none --camera none.mkv",),
        3,
    ),
    Target("rec/angle.csv", TABLE, ("compare model.toml rec", "excite --analyse rec"), 12),
    Target("rec/horn.csv", TABLE, ("compare model.toml rec", "excite --analyse rec"), 6),
    Target("rec/track.toml", SETTINGS, ("track rec", "compare model.toml rec"), 6),
    Target("command.csv", TABLE, ("excite --check command.csv --model model.toml",), 6),
    Target(
        "model.toml",
        SETTINGS,
        ("compare model.toml log.csv", "add model.toml dead_time log.csv"),
        8,
    ),
    Target(
        "model.toml",
        SETTINGS,
        (
            "export model.toml --to csv -o new.out",
            "export model.toml --to mjcf --on rec -o new.out",
        ),
        3,
    ),
    Target("model.fmu", BYTES, ("compare model.fmu log.csv --trust",), 1),
    Target("scenario.toml", SETTINGS, ("simulate scenario.toml -o new",), 6),
    Target("camera.toml", SETTINGS, ("track clip.mkv --camera camera.toml -o new.csv",), 6),
    Target("bam.json", TEXT, ("import bam.json -o new",), 8),
    Target("log.mat", BYTES, ("import log.mat -o new",), 1),
    Target("log.json", TEXT, ("import log.json -o new",), 4),
    Target("log.parquet", BYTES, ("import log.parquet -o new",), 1),
    Target("log.ulg", BYTES, (f"import log.ulg -o new {MESSAGES}",), 1),
    Target("log.mcap", BYTES, (f"import log.mcap -o new {MESSAGES}",), 1),
    Target("set/meta/info.json", TEXT, (f"import set -o new {JOINTS}",), 1),
    Target("set/data/a.parquet", BYTES, (f"import set -o new {JOINTS}",), 1),
    Target("clip.mkv", BYTES, ("track clip.mkv --pivot 32,24 -o new.csv",), 4),
    Target(
        "clip.mkv",
        BYTES,
        ("bench check --camera clip.mkv", "bench cameras --camera clip.mkv --exposure 0.001"),
        2,
    ),
    Target("film/frames.csv", TABLE, ("track film --pivot 32,24",), 1),
    Target("plugin.py", TEXT, ("effects --plugin plugin.py",), 8),
    # Read to its end, then refused, as the rows would replace a file.
    Target("sweep.toml", SETTINGS, ("sweep sweep.toml -o log.csv --workers 0",), 6),
    Target("swept/sweep.json", TEXT, ("results swept --json -",), 3),
    Target("answers.json", TEXT, ("advise --size 0.5 --results answers.json --json -",), 1),
    Target("swept/part-0.parquet", BYTES, ("results swept --json -",), 2),
)
OPTIONS = {
    "simulate": ("--effect", "--set", "--seed", "-o"),
    "import": ("-o", "--map", "--unit", "--unit-scale", "--deg-per-us", "--neutral-us"),
    "track": (
        *("--pivot", "--template", "--tip", "--at", "--pick", "--camera", "--light", "--marker"),
        *("--id", "-o", "--sheet"),
    ),
    "identify": ("--effects", "--method", "--seed", "-o", "--json", "--plugin", "--deg-per-us"),
    "compare": ("--json", "--report", "--plugin", "--neutral-us"),
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


def write_inputs(folder: Path) -> None:
    """Write a valid input of every format into ``folder``."""
    from servosight.app.main import main

    times = [0.02 * i for i in range(60)]
    command = [10 * math.sin(3 * t) + 4 * math.sin(17 * t) for t in times]
    angle = [10 * math.sin(3 * t - 0.12) + 3 * math.sin(17 * t - 0.6) for t in times]
    both = list(zip(times, command, angle, strict=True))
    texts = {
        "log.csv": _table("time_s,command_deg,angle_deg", both),
        "command.csv": _table("time_s,command_deg", [(t, u) for t, u, _ in both]),
        "rec/recording.toml": SETTINGS_TOML,
        "rec/command.csv": _table("time_s,command_deg", [(t, u) for t, u, _ in both]),
        "rec/angle.csv": _table("time_s,angle_deg,sigma_deg", [(t, y, 0.02) for t, _, y in both]),
        "rec/horn.csv": _table("time_s,angle_deg", [(t, y) for t, _, y in both]),
        "rec/track.toml": TRACK_TOML,
        "camera.toml": CAMERA,
        "scenario.toml": SCENARIO,
        "sweep.toml": SWEEP,
        "plugin.py": PLUGIN,
        "bam.json": json.dumps(_bam(both)),
        "answers.json": SHIPPED.read_text(encoding="utf-8"),
    }
    for name, text in texts.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    with contextlib.redirect_stdout(io.StringIO()):
        words = ["identify", str(folder / "log.csv"), "--method", "gradient"]
        assert main([*words, "-o", str(folder / "model.toml")]) == 0
        words = ["export", str(folder / "model.toml"), "--to", "fmu"]
        if main([*words, "-o", str(folder / "model.fmu")]) != 0:  # without a C compiler
            (folder / "model.fmu").write_bytes(b"PK")
        rows = folder / "swept"
        words = ["sweep", str(folder / "sweep.toml"), "--workers", "0", "-q"]
        assert main([*words, "-o", str(rows)]) == 0
    (part,) = rows.glob("part-*.parquet")
    part.rename(rows / "part-0.parquet")
    (rows / ".lock").unlink()
    _write_mat(folder / "log.mat", both)
    write_logs(folder, both)
    _write_film(folder / "clip.mkv")
    (folder / "film").mkdir()
    (folder / "film" / "video.mkv").write_bytes((folder / "clip.mkv").read_bytes())
    (folder / "film" / "command.csv").write_text(texts["command.csv"])
    frames = [(float(n), 0.02 * n, 0.001) for n in range(60)]
    (folder / "film" / "frames.csv").write_text(_table("frame,time_s,exposure_s", frames))


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


def _table(header: str, rows: list[tuple[float, ...]]) -> str:
    body = "".join(",".join(f"{x:.6f}".rstrip("0") for x in row) + "\n" for row in rows)
    return f"{header}\n{body}"


def _bam(rows: list[tuple[float, float, float]]) -> dict[str, object]:
    entries = [
        {
            "timestamp": t,
            "position": math.radians(y),
            "goal_position": math.radians(u),
            "torque_enable": True,
        }
        for t, u, y in rows
    ]
    return {"mass": 0.1, "length": 0.1, "kp": 32, "motor": "x", "dt": 0.02, "entries": entries}


def _write_mat(path: Path, rows: list[tuple[float, float, float]]) -> None:
    import numpy as np
    from scipy.io import savemat

    t, u, y = np.array(rows).T
    savemat(path, {"t": t[:, None], "qg": u[:, None] / 100, "qm": y[:, None] / 100})


def _write_film(path: Path) -> None:
    """60 frames of a bar that turns, 64 by 48 pixels."""
    import av
    import cv2
    import numpy as np

    with av.open(str(path), "w") as container:
        stream = container.add_stream("ffv1", rate=50)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "gray"
        for index in range(60):
            image = np.full((48, 64), 90, np.uint8)
            angle = 0.4 * math.sin(0.2 * index)
            tip = (round(16 * (32 + 18 * math.cos(angle))), round(16 * (24 - 18 * math.sin(angle))))
            cv2.line(image, (16 * 32, 16 * 24), tip, 220, 5, cv2.LINE_AA, 4)
            frame = av.VideoFrame.from_ndarray(image, format="gray")
            container.mux(stream.encode(frame))
        container.mux(stream.encode())


if __name__ == "__main__":
    write_inputs(Path(sys.argv[1]))
