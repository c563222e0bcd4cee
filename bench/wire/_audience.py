"""Those who watch a virtual camera: each gets every frame, and the bench waits until it has it.

What reads a camera's frames is a thread of its own, while the time of a virtual bench passes where
somebody waits on its clock. Without more, how far that thread has come would depend on what else
the computer does, and no two runs would be the same.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator, Iterator
from contextlib import closing, contextmanager
from queue import Queue

from servosight.bench.camera import CapturedFrame, OpenCamera
from servosight.bench.wire._mjpeg import ServedFrame

_PATIENCE_S = 5.0


class _Watcher:
    """One who gets frames, and the number of the last frame that was dealt with; None before."""

    def __init__(self) -> None:
        self.queue: Queue[ServedFrame | None] = Queue()
        self.dealt: int | None = None


class Audience:
    """All who watch a virtual camera, over the network or as readers in this process.

    ``show`` returns when the frame is on the network to each of them, and when each reader of a
    camera from ``attended`` has come back for the next one or has left. So the time of the bench
    stands still while a reader works, and a run is the same each time.
    """

    def __init__(self) -> None:
        self._clients: list[_Watcher] = []
        self._readers: list[_Watcher] = []
        self._changed = threading.Condition()

    @property
    def there(self) -> bool:
        """Whether anybody watches."""
        return bool(self._clients)

    def stream(self, first: Callable[[], ServedFrame]) -> Iterator[ServedFrame]:
        """The frames for a client on the network: ``first`` at once, then each that is shown."""
        one = first()
        with self._among(self._clients) as client:
            yield one
            while (frame := client.queue.get()) is not None:
                yield frame
                self._has_dealt(client, frame.number)

    def show(self, frame: ServedFrame) -> None:
        """Hand a frame to all; who is not done with it after five seconds is given up."""
        with self._changed:
            for client in self._clients:
                client.dealt = -1  # waited for from now on
                client.queue.put(frame)
            if not self._changed.wait_for(lambda: not self._behind(frame.number), _PATIENCE_S):
                for watcher in self._behind(frame.number):
                    self._remove(watcher)

    def end(self) -> None:
        """End the stream of everybody, as a camera that is unplugged does."""
        with self._changed:
            for client in self._clients:
                client.queue.put(None)

    def attended(self, camera: OpenCamera) -> OpenCamera:
        """``camera``, which shows these frames, for a reader that time is to wait for."""
        return _Attended(camera, self)

    def read(self, frames: Generator[CapturedFrame]) -> Generator[CapturedFrame]:
        """Pass on frames, and note when the reader is done with each."""
        with self._among(self._readers) as reader, closing(frames):
            for frame in frames:
                reader.dealt = -1 if reader.dealt is None else reader.dealt
                yield frame
                self._has_dealt(reader, frame.number)

    def _behind(self, number: int) -> list[_Watcher]:
        """Who has begun, and is not done with a frame."""
        everybody = [*self._clients, *self._readers]
        return [one for one in everybody if one.dealt is not None and one.dealt < number]

    def _has_dealt(self, watcher: _Watcher, number: int) -> None:
        with self._changed:
            watcher.dealt = number
            self._changed.notify_all()

    @contextmanager
    def _among(self, group: list[_Watcher]) -> Iterator[_Watcher]:
        watcher = _Watcher()
        with self._changed:
            group.append(watcher)
        try:
            yield watcher
        finally:
            with self._changed:
                self._remove(watcher)
                self._changed.notify_all()

    def _remove(self, watcher: _Watcher) -> None:
        for group in (self._clients, self._readers):
            if watcher in group:
                group.remove(watcher)


class _Attended:
    """A camera whose frames are read under the eyes of an audience."""

    def __init__(self, camera: OpenCamera, audience: Audience) -> None:
        self.name, self.stream = camera.name, camera.stream
        self._camera, self._audience = camera, audience

    def frames(self) -> Generator[CapturedFrame]:
        """Frames as they come from now on."""
        return self._audience.read(self._camera.frames())

    def close(self) -> None:
        """Stop the stream."""
        self._camera.close()
