"""Peak memory of the tracker over the length of a video."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import av

from filmed.cases import VideoCase, fast, filmed
from filmed.measure import CLIPS, verdict
from servosight.models.core import Camera
from servosight.models.io import MatroskaWriter
from servosight.sim.film._codec import MagicYuvEncoder
from servosight.tracking.core import TrackOptions
from servosight.tracking.track import track

_LONG_S = (10, 60)


def memory() -> str:
    """Peak memory of tracking the same two seconds over and over, for long and for longer."""
    camera = Camera(exposure_s=0.002, width=320, height=240)
    case = VideoCase("small", lambda t: 0.75 * fast(t * 2.5 / 2.4), camera, duration_s=2.01)
    video, _ = filmed(case, CLIPS)
    peaks = []
    for length_s in _LONG_S:
        looped = CLIPS / f"looped_{length_s}.mkv"
        _loop(video, looped, length_s)
        code = "import sys; from filmed.memory import peak; peak(sys.argv[1])"
        out = subprocess.run(
            [sys.executable, "-c", code, str(looped)],
            cwd=Path(__file__).resolve().parents[1],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        peaks.append(float(out.split()[-1]))
        looped.unlink()
    growth = peaks[1] / peaks[0] - 1.0
    return (
        f"| peak memory, {_LONG_S[1]} s against {_LONG_S[0]} s of 320 x 240 px: "
        f"{peaks[1]:.0f} against {peaks[0]:.0f} MB, growth | 0.1 | {growth:.2g} | "
        f"{verdict(growth, 0.1)} |"
    )


def peak(video: str) -> None:
    """Track and print the peak of resident memory [MB]; getrusage's would be the parent's too."""
    track(Path(video), TrackOptions(exposure_s=0.002))
    status = Path("/proc/self/status").read_text()
    print(float(status.split("VmHWM:")[1].split()[0]) / 1024.0)


def _loop(video: Path, looped: Path, length_s: int) -> None:
    """The video's packets written again and again; its pictures stand each by itself."""
    with av.open(str(video)) as source:
        stream = source.streams.video[0]
        size = stream.width, stream.height
        packets = [bytes(packet) for packet in source.demux(stream) if packet.size][:240]
    film = MagicYuvEncoder(*size)
    with (
        looped.open("wb") as file,
        MatroskaWriter(file, size, film.matroska_id, film.private, 1 / 120) as sink,
    ):
        for number in range(120 * length_s):
            sink.write(round(number * 1e6 / 120), packets[number % len(packets)])
