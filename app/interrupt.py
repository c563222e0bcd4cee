"""An interruption ends the process soon, whatever it is at, and leaves no temporary file behind.

SIGINT (Ctrl-C), SIGTERM and SIGHUP raise :class:`Interrupted` in the main thread, so that every
block is left in order. Modules that are being imported may swallow that exception or turn it into
another, and native code delays it: therefore a second thread waits for ``GRACE_S`` and then ends
the process itself. Nothing here imports anything that takes time: it is the first to be loaded.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from types import FrameType, TracebackType

GRACE_S = 1.2
CODES = {signal.SIGINT: 130, signal.SIGTERM: 143, signal.SIGHUP: 129}
"""Exit codes: 128 and the signal's number, as a shell reports them."""
SHOW_CURSOR = b"\x1b[?25h"

_received: list[int] = []
_cleaners: list[Callable[[], None]] = []
_ending: list[bool] = []


class Interrupted(KeyboardInterrupt):
    """The process was asked to end."""


def install() -> None:
    """Handle the signals, but for those that whoever started the process has had ignored."""
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    threading.Thread(target=_watch, args=(reading,), daemon=True).start()
    sys.unraisablehook = _unraisable
    sys.excepthook = _uncaught
    for number in CODES:
        if signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _interrupt)


def clean_with(cleaner: Callable[[], None]) -> None:
    """Call ``cleaner`` before an interrupted process ends."""
    if cleaner not in _cleaners:
        _cleaners.append(cleaner)


def received() -> int | None:
    """The signal that came, None while there was none."""
    return _received[0] if _received else None


def exit_code() -> int:
    """The exit code of an interrupted process; SIGINT's where Python itself raised."""
    return CODES[signal.Signals(received() or signal.SIGINT)]


def leave(code: int) -> None:
    """End an interrupted process at once; from now on a signal ends any other at once, too."""
    _ending.append(True)
    if _received:
        for cleaner in _cleaners:  # the signal may have come between a temporary and its block
            cleaner()
        for stream in (sys.stdout, sys.stderr):
            try:
                stream.flush()
            except (OSError, ValueError):
                continue
        os._exit(code)


def _interrupt(number: int, frame: FrameType | None) -> None:
    if _ending:  # the work is done, and the interpreter is shutting down
        os._exit(CODES[signal.Signals(number)])
    if not _received:  # later ones would disturb those that clean up
        _received.append(number)
        raise Interrupted


def _unraisable(what: sys.UnraisableHookArgs) -> None:
    """Say nothing of what objects that an interruption left half made do when they are deleted."""
    if not _received:
        sys.__unraisablehook__(what)


def _uncaught(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    """Say nothing of an interruption that native code has caught and prints: a command that was
    killed 0.2 s after its start showed a traceback."""
    if not issubclass(kind, Interrupted):
        sys.__excepthook__(kind, error, trace)


def _watch(reading: int) -> None:
    """Wait for a signal, give the main thread time to end, then end the process."""
    number = os.read(reading, 1)[0]
    while number not in CODES:
        number = os.read(reading, 1)[0]
    time.sleep(GRACE_S)
    for cleaner in _cleaners:
        cleaner()
    try:
        restore = SHOW_CURSOR if os.isatty(sys.stderr.fileno()) else b""
        os.write(sys.stderr.fileno(), restore + b"servosight: interrupted\n")
    except (OSError, ValueError):
        pass
    os._exit(CODES[signal.Signals(number)])
