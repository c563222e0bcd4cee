"""A pseudo-terminal with a stand-in at its far end, and faults in between."""

from __future__ import annotations

import contextlib
import fcntl
import math
import os
import pty
import sys
import tty
from dataclasses import dataclass

import numpy as np

from servosight.bench.wire._standin import StandIn
from servosight.models.core import InputError

_CHUNK = 4096
_TERMIOS2 = 44
_TCGETS2 = 0x802C542A
"""Linux's struct termios2 ends with the output rate in bit/s, whichever way it was set."""
_BITS = 10
"""Bits on the wire for a byte: start, eight, stop."""


@dataclass(frozen=True, kw_only=True)
class Faults:
    """What goes wrong on a wire; nothing by default.

    ``lost`` and ``flipped`` are the shares of bytes that vanish and of bytes with one flipped bit,
    in both directions. From ``stalled_s`` on the servo is silent for ``stall_s``; at
    ``unplugged_s`` the port is gone. ``strange`` is the share of answers in front of which
    ``stranger``, another servo's answer, appears. Times are since the wire's first use.
    """

    seed: int = 0
    lost: float = 0.0
    flipped: float = 0.0
    strange: float = 0.0
    stranger: bytes = b""
    stalled_s: float = math.inf
    stall_s: float = 0.0
    unplugged_s: float = math.inf


class Wire:
    """A serial line whose near end is the device at ``path``.

    Bytes take their time at the stand-in's baud rate. A port opened at another rate sees noise.
    """

    def __init__(self, servo: StandIn, faults: Faults | None = None) -> None:
        """Open the pseudo-terminal."""
        self.servo = servo
        self._faults = faults or Faults()
        self._random = np.random.default_rng(self._faults.seed)
        try:
            self.far, self._near = pty.openpty()
        except OSError as error:
            raise InputError(
                f"/dev/pts: no pseudo-terminal to be had ({error}), expected one for each virtual "
                f"servo; mount devpts there, as a container or chroot may lack it"
            ) from None
        tty.setraw(self._near)
        os.set_blocking(self.far, False)
        self.path = os.ttyname(self._near)
        self._start_s: float | None = None
        self._there: list[tuple[float, bytes]] = []
        self._back: list[tuple[float, bytes]] = []

    def pump(self, now_s: float) -> float:
        """Pass on what is to be passed on by now; return when something is next, inf without."""
        if self._start_s is None:
            self._start_s = now_s
        if self.far >= 0 and now_s >= self._start_s + self._faults.unplugged_s:
            self.close()
        if self.far >= 0:
            data = self._written()
            if data:
                free_s = max(now_s, self._there[-1][0] if self._there else 0.0)
                self._there.append((free_s + len(data) * _BITS / self.servo.baud, data))
        while self._there and self._there[0][0] <= now_s:
            self._deliver(*self._there.pop(0))
        while self._back and self._back[0][0] <= now_s:
            with contextlib.suppress(BlockingIOError):  # nobody reads: the bytes are lost
                os.write(self.far, self._back.pop(0)[1])
        self.servo.advance(now_s)
        events = [self._start_s + self._faults.unplugged_s] if self.far >= 0 else []
        events += [queue[0][0] for queue in (self._there, self._back) if queue]
        return min(events, default=math.inf)

    def close(self) -> None:
        """Unplug it: the near end's next read or write fails."""
        for fd in (self.far, self._near):
            if fd >= 0:
                os.close(fd)
        self.far = self._near = -1
        self._there.clear()
        self._back.clear()

    def _written(self) -> bytes:
        """All that was written at the near end since the last call."""
        data = b""
        with contextlib.suppress(BlockingIOError):
            while chunk := os.read(self.far, _CHUNK):
                data += chunk
        return data

    def _deliver(self, at_s: float, data: bytes) -> None:
        """Give bytes to the servo, and put its answers on the wire."""
        assert self._start_s is not None
        faults = self._faults
        self.servo.advance(at_s)
        data = self._damaged(data)
        answers = self.servo.receive(data, at_s) if data else []
        if 0.0 <= at_s - self._start_s - faults.stalled_s < faults.stall_s:
            return
        at_s = max(at_s, self._back[-1][0] if self._back else 0.0)
        for answer in answers:
            if self._random.random() < faults.strange:
                answer = faults.stranger + answer
            at_s += self.servo.return_delay_s + len(answer) * _BITS / self.servo.baud
            self._back.append((at_s, self._damaged(answer)))

    def _damaged(self, data: bytes) -> bytes:
        """What arrives of some bytes."""
        if self._near >= 0 and not self._same_rate():
            return bytes(self._random.integers(0, 256, max(1, len(data) // 2)).tolist())
        faults = self._faults
        if not (faults.lost or faults.flipped):
            return data
        arrived = bytearray()
        for byte, lot in zip(data, self._random.random(len(data)), strict=True):
            if lot < faults.lost:
                continue
            flips = lot < faults.lost + faults.flipped
            arrived.append(byte ^ (1 << int(self._random.integers(0, 8))) if flips else byte)
        return bytes(arrived)

    def _same_rate(self) -> bool:
        mode = fcntl.ioctl(self._near, _TCGETS2, bytes(_TERMIOS2))
        return int.from_bytes(mode[-4:], sys.byteorder) == self.servo.baud
