"""Frames from a stream on the loopback interface, and from files, into a video of our own."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from servosight.bench.camera import (
    CameraLost,
    Footage,
    Given,
    Recorder,
    jpeg_size,
    open_camera,
)
from servosight.bench.wire import MjpegServer, ServedFrame
from servosight.models.core import InputError
from servosight.models.io import MatroskaWriter

SHORT = Given(timeout_s=0.5)


def jpeg(n: int) -> bytes:
    image = np.full((64, 96), 20 + n % 200, np.uint8)
    return bytes(cv2.imencode(".jpg", image)[1].tobytes())


def film(
    count: int, *, rate_hz: float = 250.0, lost: tuple[int, ...] = (), stamped: bool = True
) -> Callable[[], Iterator[ServedFrame]]:
    """Frames of a camera whose clock began 100 s before the host's."""

    def frames() -> Iterator[ServedFrame]:
        begin_s = time.monotonic()
        for n in range(count):
            if n in lost:
                continue
            due_s = begin_s + n / rate_hz
            time.sleep(max(due_s - time.monotonic(), 0.0))
            stamp_s = due_s + 100.0 if stamped else None
            yield ServedFrame(number=n, stamp_s=stamp_s, data=jpeg(n))

    return frames


def ended(recorder: Recorder, until_s: float) -> Footage:
    """Wait for the recorder to end by itself; it has five seconds."""
    recorder.stop_after(until_s)
    assert recorder.ended.wait(5.0)
    return recorder.finish()


def test_the_cameras_own_jpegs_and_stamps_go_to_disk_untouched(tmp_path: Path) -> None:
    with MjpegServer(film(400, lost=(10, 11, 30))) as server:
        camera = open_camera(server.address, SHORT)
        assert camera.stream.size == (96, 64)
        assert camera.stream.meaning == "frame_end"
        recorder = Recorder(camera, tmp_path)
        recorder.start()
        footage = ended(recorder, time.monotonic() + 0.6)
        camera.close()
    assert footage.fault is None
    assert footage.lost == 3
    assert footage.rate_hz == pytest.approx(250.0, rel=1e-3)
    assert -100.0 < footage.delay_s < -99.9
    with av.open(str(tmp_path / "video.mkv")) as container:
        video = container.streams.video[0]
        packets = [p for p in container.demux(video) if p.size]
        assert video.codec_context.name == "mjpeg"
        times_s = [float(p.pts * p.time_base) for p in packets]
    assert [bytes(p) for p in packets] == [jpeg(int(n)) for n in footage.number]
    np.testing.assert_allclose(times_s, footage.stamp_s - footage.stamp_s[0], atol=1e-6)


def test_a_recording_ends_with_what_the_camera_took_up_to_the_given_time(tmp_path: Path) -> None:
    with MjpegServer(film(200)) as server:
        camera = open_camera(server.address, SHORT)
        recorder = Recorder(camera, tmp_path)
        recorder.start()
        until_s = time.monotonic() + 0.2
        footage = ended(recorder, until_s)
        camera.close()
    assert until_s - 0.005 < footage.stamp_s[-1] - 100.0 < until_s + 0.05
    assert 20 < footage.number.size < 150


def test_what_was_recorded_before_a_fault_is_kept(tmp_path: Path) -> None:
    with MjpegServer(film(20)) as server:
        camera = open_camera(server.address, SHORT)
        recorder = Recorder(camera, tmp_path)
        recorder.start()
        footage = ended(recorder, time.monotonic() + 5.0)
        camera.close()
    assert footage.fault is not None
    assert "the stream ended" in footage.fault
    assert footage.number.tolist() == list(range(20))
    with av.open(str(tmp_path / "video.mkv")) as container:
        assert sum(1 for _ in container.decode(video=0)) == 20


def test_a_camera_that_freezes_is_given_up_after_its_timeout(tmp_path: Path) -> None:
    thaw = threading.Event()

    def frozen() -> Iterator[ServedFrame]:
        yield from film(5)()
        thaw.wait(5.0)

    with MjpegServer(frozen) as server:
        camera = open_camera(server.address, SHORT)
        recorder = Recorder(camera, tmp_path)
        recorder.start()
        footage = ended(recorder, time.monotonic() + 5.0)
        thaw.set()
        camera.close()
    assert footage.fault is not None
    assert "0.5 s" in footage.fault
    assert footage.number.size == 5


def test_without_stamps_the_arrival_is_the_time_and_said_so() -> None:
    with MjpegServer(film(3, stamped=False)) as server:
        camera = open_camera(server.address, SHORT)
        assert camera.stream.meaning == "arrival"
        given = Given(timeout_s=0.5, meaning="exposure_start", exposure_s=0.004)
        other = open_camera(server.address, given)
        assert (other.stream.meaning, other.stream.exposure_s) == ("exposure_start", 0.004)
        camera.close()
        other.close()


def test_what_is_no_stream_is_refused_in_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(CameraLost, match="does not answer"):
        open_camera(f"http://127.0.0.1:{free_port()}/", SHORT)
    text = ServedFrame(number=0, stamp_s=0.0, data=b"text")
    with MjpegServer(lambda: iter([text])) as server, pytest.raises(InputError, match="no JPEG"):
        open_camera(server.address, SHORT)
    with pytest.raises(InputError, match="names no host"):
        open_camera("http:///stream", SHORT)
    with pytest.raises(InputError, match="no such file"):
        open_camera(str(tmp_path / "none.mkv"), SHORT)
    (tmp_path / "text.mkv").write_text("nothing")
    with pytest.raises(InputError, match="cannot be opened"):
        open_camera(str(tmp_path / "text.mkv"), SHORT)


def free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def test_a_file_is_a_camera_too_and_its_codec_becomes_ffv1(tmp_path: Path) -> None:
    source = tmp_path / "clip.mp4"
    with av.open(str(source), "w") as container:
        out = container.add_stream("mpeg4", rate=50)
        out.width, out.height = 96, 64
        for n in range(12):
            image = np.full((64, 96), 10 * n, np.uint8)
            container.mux(out.encode(av.VideoFrame.from_ndarray(image, format="gray")))
        container.mux(out.encode(None))
    camera = open_camera(str(source))
    assert (camera.stream.coding, camera.stream.meaning) == ("gray", "exposure_start")
    recorder = Recorder(camera, tmp_path)
    recorder.start()
    footage = ended(recorder, float("inf"))
    camera.close()
    np.testing.assert_allclose(np.diff(footage.stamp_s), 0.02, atol=1e-6)
    with av.open(str(tmp_path / "video.mkv")) as container:
        assert container.streams.video[0].codec_context.name == "ffv1"
        assert sum(1 for _ in container.decode(video=0)) == 12


def test_the_size_of_a_jpeg_is_read_from_its_header() -> None:
    assert jpeg_size(jpeg(0)) == (96, 64)
    assert jpeg_size(jpeg(0)[:20]) is None


def test_a_file_of_an_unknown_coding_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "strange.mkv"
    with file.open("wb") as target, MatroskaWriter(target, (96, 64), "V_STRANGE", b"", 0.02) as out:
        out.write(0, b"picture")
    with pytest.raises(InputError, match="does not know"):
        open_camera(str(file))
