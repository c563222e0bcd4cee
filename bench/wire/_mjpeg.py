"""A camera on the wire: MJPEG over HTTP on the loopback interface, and on no other."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType

_BOUNDARY = "frame"
LOOPBACK = "127.0.0.1"


@dataclass(frozen=True, kw_only=True)
class ServedFrame:
    """A JPEG, its number, and its time on the camera's clock; None where the camera tells none."""

    number: int
    stamp_s: float | None
    data: bytes


class MjpegServer:
    """Serves what ``film`` yields to whoever asks at ``address``; each client gets its own film.

    The iterator decides when a frame is sent: it blocks until the frame is there. Where it ends,
    the connection is closed, as when a camera is unplugged.
    """

    def __init__(self, film: Callable[[], Iterator[ServedFrame]]) -> None:
        class Handler(BaseHTTPRequestHandler):
            protocol_version = "HTTP/1.0"  # the end of the stream is the end of the connection

            def do_GET(self) -> None:
                _serve(self, film())

            def log_message(self, format: str, *args: object) -> None:
                """Say nothing."""

        self._server = ThreadingHTTPServer((LOOPBACK, 0), Handler)
        self._server.daemon_threads = True
        self._thread = threading.Thread(
            target=self._server.serve_forever, args=(0.05,), name="camera on the wire", daemon=True
        )
        self._thread.start()

    @property
    def address(self) -> str:
        """Where the stream is, such as ``http://127.0.0.1:40123/stream``."""
        return f"http://{LOOPBACK}:{self._server.server_address[1]}/stream"

    def close(self) -> None:
        """Serve no one any more."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join(2.0)

    def __enter__(self) -> MjpegServer:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def _serve(handler: BaseHTTPRequestHandler, film: Iterator[ServedFrame]) -> None:
    handler.send_response(200)
    handler.send_header("Content-Type", f"multipart/x-mixed-replace;boundary={_BOUNDARY}")
    handler.end_headers()
    try:
        for frame in film:
            lines = [f"--{_BOUNDARY}", "Content-Type: image/jpeg"]
            lines += [f"Content-Length: {len(frame.data)}", f"X-Sequence: {frame.number}"]
            if frame.stamp_s is not None:
                lines.append(f"X-Timestamp: {frame.stamp_s:.6f}")
            head = "\r\n".join(lines).encode() + b"\r\n\r\n"
            handler.wfile.write(head + frame.data + b"\r\n")
    except OSError:  # the client has left
        return
