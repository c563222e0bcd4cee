"""A serial port: a terminal device in raw mode, read with a time-out and written at once.

Plain termios suffices for what four drivers need, on the systems that the project supports, and
gives the file descriptor on which a clock waits; pyserial would be a dependency for the same.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import sys
import termios
import tty
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from servosight.bench.host_clock import Clock
from servosight.bench.servo._protocol import LinkLost
from servosight.models.core import InputError

T = TypeVar("T")

ANSWER_S = 0.03
"""Time for an answer: 16 ms of an FTDI adapter's latency timer, and as much again."""
QUIET_S = 0.02
TRIES = 3
BITS = 10
"""Bits on the wire for a byte: start, eight, stop."""
_CHUNK = 4096
_TIOCGSERIAL, _TIOCSSERIAL = 0x541E, 0x541F
_SERIAL_STRUCT = 128
_LOW_LATENCY = 0x2000
"""Linux's serial_struct, more than its length, whose fifth word holds the flags; with this one an
FTDI adapter hands on its bytes after 1 ms instead of 16 (linux/tty_flags.h, ASYNC_LOW_LATENCY)."""
_MOST_CHUNKS = 20
LINES = {"dtr": 0x002, "rts": 0x004}
"""Output lines of a serial adapter, by their bits (linux/termios.h, TIOCM_DTR and TIOCM_RTS)."""
LINE_SIGMA_S = 0.5e-3
"""Of a USB adapter, which takes orders once in a millisecond."""


class Port:
    """An open serial port; ``name`` is what messages call the device behind it."""

    def __init__(self, path: str, baud: int, clock: Clock, name: str) -> None:
        """Open ``path`` for this process alone; InputError where that does not work."""
        speed = getattr(termios, f"B{baud}", None)
        if speed is None:
            raise InputError(
                f"{name}: this system's serial ports have no baud rate of {baud}, expected one "
                f"such as 57600, 115200 or 1000000; set another rate in the servo and here"
            )
        self.name = name
        self.clock = clock
        self.byte_s = BITS / baud
        self._free_s = 0.0
        flags = os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK | os.O_CLOEXEC
        try:
            self._fd = os.open(path, flags)
        except (OSError, ValueError) as error:  # ValueError: a null byte in the path
            why = getattr(error, "strerror", None) or error
            raise InputError(
                f"{name}: cannot open {path!a}: {why}; check the path (ls "
                f"/dev/serial/by-id) and that you may use it (group dialout)"
            ) from error
        try:
            self._set_up(speed)
        except (OSError, termios.error) as error:
            os.close(self._fd)
            raise InputError(
                f"{name}: {path} cannot be used as a serial port ({error.args[-1]}), expected one "
                f"that no other program uses; close the other program or correct the path"
            ) from error

    def _set_up(self, speed: int) -> None:
        fcntl.flock(self._fd, fcntl.LOCK_EX | fcntl.LOCK_NB)
        tty.setraw(self._fd, termios.TCSANOW)
        mode = termios.tcgetattr(self._fd)
        mode[2] |= termios.CLOCAL | termios.CREAD
        mode[2] &= ~(termios.CRTSCTS | termios.CSTOPB | termios.PARENB | termios.HUPCL)
        mode[4] = mode[5] = speed
        termios.tcsetattr(self._fd, termios.TCSANOW, mode)
        termios.tcflush(self._fd, termios.TCIOFLUSH)
        with contextlib.suppress(OSError):  # not every driver knows it
            serial = bytearray(fcntl.ioctl(self._fd, _TIOCGSERIAL, bytes(_SERIAL_STRUCT)))
            flags = int.from_bytes(serial[16:20], sys.byteorder) | _LOW_LATENCY
            serial[16:20] = flags.to_bytes(4, sys.byteorder)
            fcntl.ioctl(self._fd, _TIOCSSERIAL, bytes(serial))

    def write(self, data: bytes) -> float:
        """Hand over bytes when those before are over the wire; the time at which the last one is.

        Handed over earlier, they would wait in the system's queue for a time that nobody notes.
        """
        if self.clock.now() < self._free_s:
            self.clock.wait(self._free_s, self._fd)
        start = max(self.clock.now(), self._free_s)
        try:
            written = os.write(self._fd, data)
        except OSError as error:
            raise self._lost(error) from error
        if written < len(data):
            raise LinkLost(f"{self.name}: the port takes no more bytes; check the cable")
        self._free_s = start + len(data) * self.byte_s
        return self._free_s

    def read(self, until_s: float) -> bytes:
        """What has come by ``until_s``; nothing where nothing has."""
        if not self.clock.wait(until_s, self._fd):
            return b""
        try:
            data = os.read(self._fd, _CHUNK)
        except BlockingIOError:
            return b""
        except OSError as error:
            raise self._lost(error) from error
        if not data:
            raise self._lost(None)
        return data

    def flush(self) -> None:
        """Forget what has come and nobody read: late answers to earlier questions."""
        with contextlib.suppress(OSError):
            while os.read(self._fd, _CHUNK):
                pass

    def drain(self) -> None:
        """Forget what has come, and what comes until the line is quiet for 20 ms."""
        for _ in range(_MOST_CHUNKS):
            if not self.read(self.clock.now() + QUIET_S):
                break

    def switch(self, line: str, on: bool) -> float:
        """Set an output line of the adapter, "dtr" or "rts"; the host's time in the middle of it.

        An asserted line of a TTL adapter is at 0 V.
        """
        start = self.clock.now()
        order = termios.TIOCMBIS if on else termios.TIOCMBIC
        try:
            fcntl.ioctl(self._fd, order, LINES[line].to_bytes(4, sys.byteorder))
        except OSError as error:
            raise InputError(
                f"{self.name}: the adapter has no output line {line.upper()} ({error.strerror}), "
                f"expected one; leave light={line} out of the address"
            ) from error
        return 0.5 * (start + self.clock.now())

    def close(self) -> None:
        """Let go of the port; nothing happens where it is closed already."""
        if self._fd >= 0:
            os.close(self._fd)
            self._fd = -1

    def _lost(self, error: OSError | None) -> LinkLost:
        why = f" ({error.strerror})" if error and error.strerror else ""
        return LinkLost(f"{self.name}: the serial port is gone{why}; plug the cable in again")


class LineLamp:
    """A light between an output line of the serial adapter and its supply (``Lamp``)."""

    sigma_s = LINE_SIGMA_S

    def __init__(self, port: Port, line: str) -> None:
        """Dark to begin with: a port asserts its lines when it is opened."""
        self._port, self._line = port, line

    def switch(self, on: bool) -> float:
        """Switch it; the host's time of that, in s."""
        return self._port.switch(self._line, on)


@dataclass(frozen=True, kw_only=True)
class Exchange:
    """When a question was over the wire, and when the answer to it began, in s.

    Both follow from the host's times and the bytes' own; what the adapter adds is in between.
    """

    asked_s: float
    answered_s: float

    @property
    def middle_s(self) -> float:
        """Halfway, the best guess of when the device looked at its sensors."""
        return 0.5 * (self.asked_s + self.answered_s)


def ask(
    port: Port, question: bytes, find: Callable[[bytes], T | None], tries: int = TRIES
) -> tuple[T, Exchange]:
    """Ask until an answer is found, ``tries`` times at most; LinkLost where none is.

    ``find`` looks for the answer in everything received since the question, and returns None as
    long as it is not there. An adapter that echoes what it sends is taken into account. Answers
    bear no number: where a question was repeated, what still comes is waited for and dropped, so
    that it is not taken for the answer to the next one.
    """
    for attempt in range(tries):
        port.flush()
        asked = port.write(question)
        received = b""
        while chunk := port.read(asked + ANSWER_S):
            received = (received + chunk).removeprefix(question)
            if (answer := find(received)) is not None:
                began = port.clock.now() - len(received) * port.byte_s
                if attempt:
                    port.drain()
                return answer, Exchange(asked_s=asked, answered_s=max(asked, began))
    raise LinkLost(
        f"{port.name}: no answer to {tries} questions within {1e3 * ANSWER_S:.0f} ms each; check "
        f"power, cable, id and baud rate"
    )
