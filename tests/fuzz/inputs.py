"""Small valid inputs of every format."""

from __future__ import annotations

import contextlib
import io
import json
import math
import sys
from pathlib import Path

from fuzz.logs import write_logs

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
