"""A servo at the end of a wire and a camera that sees nothing but its light, under one clock."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from queue import Queue

import cv2
import numpy as np

from servosight.bench.camera import Camera, Given, open_camera
from servosight.bench.light import lit_share
from servosight.bench.servo import SupervisedServo, open_servo
from servosight.bench.wire import (
    BoardStandIn,
    Faults,
    MjpegServer,
    ServedFrame,
    StandIn,
    VirtualClock,
    Wire,
)
from support.wires import KEYS, STAND_INS

RATE_HZ, EXPOSURE_S, AHEAD_S = 60.0, 0.004, 700.0
"""Frames a second, and by how much the camera's clock is ahead of the host's."""


class LightCamera:
    """Films a light that is driven by a board, or by ``begin`` and ``end``."""

    def __init__(self, board: StandIn, ends_s: float, freezes_s: float) -> None:
        self._board, self._ends_s, self._freezes_s = board, ends_s, freezes_s
        self.clock: VirtualClock | None = None
        self._plays: list[tuple[float, float | None]] = []
        self._number = 1
        self._start_s: float | None = None
        self._queue: Queue[ServedFrame | None] | None = None

    def begin(self) -> float:
        assert self.clock is not None
        self._plays.append((self.clock.now(), None))
        return self._plays[-1][0]

    def end(self) -> float:
        assert self.clock is not None
        self._plays[-1] = (self._plays[-1][0], self.clock.now())
        return self.clock.now()

    def pump(self, now_s: float) -> float:
        self._start_s = now_s if self._start_s is None else self._start_s
        while (due_s := self._begin_s(self._number) + EXPOSURE_S + 0.02) <= now_s:
            seen_s = now_s - self._start_s
            if self._queue is not None and seen_s < min(self._freezes_s, self._ends_s):
                self._queue.put(self._frame(self._number))
                self._wait()
            elif self._queue is not None and seen_s >= self._ends_s:
                self._queue.put(None)
            self._number += 1
        return due_s

    def film(self) -> Iterator[ServedFrame]:
        self._queue = queue = Queue()
        try:
            yield self._frame(self._number - 1)
            while (frame := queue.get()) is not None:
                yield frame
                queue.task_done()
        finally:
            if self._queue is queue:  # nobody reads it any more
                self._queue = None

    def _wait(self) -> None:
        queue, until_s = self._queue, time.monotonic() + 2.0
        while queue is not None and queue.unfinished_tasks and time.monotonic() < until_s:
            time.sleep(1e-4)
            queue = self._queue

    def _begin_s(self, number: int) -> float:
        return (self._start_s or 0.0) + (number - 1) / RATE_HZ

    def _frame(self, number: int) -> ServedFrame:
        begin_s = self._begin_s(number)
        plays = self._board.plays if isinstance(self._board, BoardStandIn) else self._plays
        share = 0.0
        for start_s, end_s in plays:
            ends_s = begin_s + 1.0 if end_s is None else end_s
            last_s = min(begin_s + EXPOSURE_S, ends_s)
            if last_s > begin_s:
                part = float(lit_share(np.array(begin_s - start_s), np.array(last_s - start_s)))
                share += part * (last_s - begin_s) / EXPOSURE_S
        image = np.full((64, 96), 60, np.uint8)
        image[16:40, 24:48] += np.uint8(round(150 * min(share, 1.0)))
        data = cv2.imencode(".jpg", image)[1].tobytes()
        return ServedFrame(number=number, stamp_s=begin_s + AHEAD_S, data=data)


@dataclass(frozen=True, kw_only=True)
class FilmedWire:
    """Devices as a run takes them, and what stands behind them."""

    servo: SupervisedServo
    camera: Camera
    far: StandIn
    film: LightCamera
    clock: VirtualClock

    @property
    def light(self) -> LightCamera | None:
        """The light, where the servo's board does not drive it."""
        return None if isinstance(self.far, BoardStandIn) else self.film


@contextmanager
def filmed_wire(
    kind: str,
    faults: Faults | None = None,
    ends_s: float = float("inf"),
    freezes_s: float = float("inf"),
) -> Iterator[FilmedWire]:
    """A servo of a kind and its camera; the stream ends, or freezes, so long after the start."""
    far = STAND_INS[kind]()
    wire = Wire(far, faults)
    film = LightCamera(far, ends_s, freezes_s)
    film.clock = clock = VirtualClock([wire, film])
    given = Given(exposure_s=EXPOSURE_S, meaning="exposure_start", timeout_s=0.5)
    try:
        with MjpegServer(film.film) as server:
            film.pump(clock.now())
            servo = open_servo(f"{kind}:{wire.path}?{KEYS[kind]}", clock=clock)
            camera = open_camera(server.address, given, clock.now)
            yield FilmedWire(servo=servo, camera=camera, far=far, film=film, clock=clock)
            servo.driver.close()
            camera.close()
    finally:
        wire.close()
