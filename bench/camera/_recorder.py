"""Frames to disk as they come: the video, and a row for each frame that came."""

from __future__ import annotations

import threading
from collections.abc import Generator, Iterator
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from io import FileIO
from pathlib import Path

import numpy as np

from servosight.bench.camera._protocol import CapturedFrame, OpenCamera, Stream
from servosight.bench.timing import lost_between
from servosight.models.core import Array, InputError
from servosight.models.io import TICK_S, Ffv1Encoder, MatroskaWriter

VIDEO = "video.mkv"
USUAL_RATE_HZ = 30.0
_SPARE_BYTES = 2 << 20  # what a run's tables and the video's index need, and more
_LATENCY_FRAMES = 20  # frames over which the shortest delay to the host is looked for


@dataclass(frozen=True, kw_only=True)
class Footage:
    """What was recorded, one entry a frame: number, stamp and arrival [s], (frames,) each.

    ``fault`` says in one sentence why it ended early; None where it did not.
    """

    stream: Stream
    number: Array
    stamp_s: Array
    arrival_s: Array
    fault: str | None = None

    @property
    def lost(self) -> int:
        """Frames that the camera took and that did not arrive."""
        return lost_between(self.number)

    @property
    def rate_hz(self) -> float | None:
        """The measured frame rate by the camera's clock: lost frames do not lower it."""
        if self.stamp_s.size < 2:
            return None
        counted = float(self.number[-1] - self.number[0])
        return counted / max(float(self.stamp_s[-1] - self.stamp_s[0]), 1e-9)

    @property
    def delay_s(self) -> float:
        """The shortest delay from stamp to arrival, the clocks' offset included [s]."""
        return float(np.min(self.arrival_s - self.stamp_s))


class Recorder:
    """Records in a thread of its own, from ``start`` until ``stop_after`` or ``finish``.

    Each frame is written as soon as it is there, so that memory does not grow with the length, and
    what was recorded up to a fault is kept: what is counted can be decoded, also after a full disk,
    for whose tables some space is held free meanwhile. Presentation times are the camera's stamps,
    counted from the first one, to the microsecond. A frame whose stamp does not lie after the one
    before is left out: a camera that repeats its last picture sends such.

    ``begun`` is set when the first frame is on disk, ``ended`` when no further one will be; both
    where a fault has come before, which ``fault`` then names.
    """

    def __init__(self, camera: OpenCamera, folder: Path) -> None:
        self._camera = camera
        self._path, self._spare = folder / VIDEO, folder / "spare"
        self._writer: MatroskaWriter | None = None
        self._rows: list[tuple[float, float, float]] = []
        self._fault: str | None = None
        self._until_s = float("inf")
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)
        self.begun = threading.Event()
        self.ended = threading.Event()

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    @property
    def ending(self) -> bool:
        """Whether its end was set by ``stop_after``."""
        return self._until_s < float("inf")

    @property
    def fault(self) -> str | None:
        """Why the recording ended early, as soon as it did."""
        return self._fault

    def stop_after(self, host_s: float) -> None:
        """End with what the camera takes up to ``host_s`` on the host's clock.

        The stamps decide, with the shortest delay of the first frames: a camera that delivers late
        is waited for.
        """
        self._until_s = host_s

    def finish(self) -> Footage:
        """End at once, and return what was recorded."""
        self._stop.set()
        if self._thread.ident is not None:
            self._thread.join(5.0)
        self._spare.unlink(missing_ok=True)
        return self._footage()

    def _footage(self) -> Footage:
        whole = self._rows if self._writer is None else self._rows[: self._writer.packets]
        rows = np.array(whole, dtype=np.float64).reshape(-1, 3)
        return Footage(
            stream=self._camera.stream,
            number=rows[:, 0],
            stamp_s=rows[:, 1],
            arrival_s=rows[:, 2],
            fault=self._fault,
        )

    def _run(self) -> None:
        try:
            self._record()
        except InputError as error:
            self._fault = str(error)
        except OSError as error:
            self._fault = (
                f"{VIDEO}: cannot be written further ({error.strerror or error}); make room on the "
                f"disk, or record elsewhere"
            )
        except Exception as error:  # a thread has no one to raise it to
            self._fault = f"{self._camera.name}: {type(error).__name__}: {error}"
        finally:
            self.begun.set()
            self.ended.set()

    def _record(self) -> None:
        stream = self._camera.stream
        encoder = None if stream.coding == "mjpeg" else Ffv1Encoder(*stream.size)
        codec, private = ("V_MJPEG", b"") if encoder is None else ("V_FFV1", encoder.private)
        period_s = 1.0 / (stream.rate_hz or USUAL_RATE_HZ)
        with suppress(OSError):  # a disk that has no room for it has none for a video
            self._spare.write_bytes(bytes(_SPARE_BYTES))
        with (
            self._path.open("wb", buffering=0) as file,
            closing(self._camera.frames()) as frames,
            _whole(file, self._spare, stream.size, codec, private, period_s) as writer,
        ):
            self._writer = writer
            self._write(frames, writer, encoder)

    def _write(
        self,
        frames: Generator[CapturedFrame],
        writer: MatroskaWriter,
        encoder: Ffv1Encoder | None,
    ) -> None:
        stream, last, delay_s = self._camera.stream, -1, float("inf")
        for frame in frames:
            if len(self._rows) < _LATENCY_FRAMES:
                delay_s = min(delay_s, frame.arrival_s - frame.stamp_s)
            start_s = self._rows[0][1] if self._rows else frame.stamp_s
            ticks = round((frame.stamp_s - start_s) / TICK_S)
            if ticks > last:
                writer.write(ticks, _coded(frame, stream, encoder))
                self._rows.append((float(frame.number), frame.stamp_s, frame.arrival_s))
                last = ticks
                self.begun.set()
            if self._stop.is_set() or frame.stamp_s + delay_s > self._until_s:
                self.ended.set()  # before the camera is left, which may take a while
                return


class _Whole:
    """A file without a buffer that writes all or raises: what is counted is on disk."""

    def __init__(self, file: FileIO) -> None:
        self._file = file
        self.tell, self.seek = file.tell, file.seek

    def write(self, data: bytes, /) -> int:
        left = memoryview(data)
        while left:
            left = left[self._file.write(left) :]
        return len(data)


@contextmanager
def _whole(
    file: FileIO, spare: Path, size: tuple[int, int], codec: str, private: bytes, period_s: float
) -> Iterator[MatroskaWriter]:
    """A writer whose file ends with a whole picture and an index, whatever ends the recording.

    Where the disk is full, the space of the file ``spare`` is freed for the index, and for the
    tables of the run.
    """
    writer = MatroskaWriter(_Whole(file), size, codec, private, period_s)
    try:
        yield writer
    except OSError:
        file.truncate(writer.cut())
        raise
    finally:
        spare.unlink(missing_ok=True)
        try:
            writer.close()
        except OSError:
            file.truncate(writer.cut())
            raise


def _coded(frame: CapturedFrame, stream: Stream, encoder: Ffv1Encoder | None) -> bytes:
    if encoder is None:
        return frame.data
    width, height = stream.size
    return encoder.encode(np.frombuffer(frame.data, np.uint8).reshape(height, width))
