"""A servo at the end of a wire and a camera that sees nothing but its light, under one clock."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import cv2
import numpy as np

from servosight.bench.camera import Given, OpenCamera, open_camera
from servosight.bench.light import BIT_S, PERIOD_BITS, pattern
from servosight.bench.safety import Limits
from servosight.bench.servo import SupervisedServo, open_servo
from servosight.bench.wire import (
    Audience,
    BoardStandIn,
    Faults,
    MjpegServer,
    ServedFrame,
    StandIn,
    VirtualClock,
    Wire,
)
from servosight.models.core import Array, lit_share
from support.wires import KEYS, STAND_INS

RATE_HZ, EXPOSURE_S, AHEAD_S = 60.0, 0.004, 700.0
"""Frames a second, and by how much the camera's clock is ahead of the host's."""


def seen_share(start_s: Array, end_s: Array) -> Array:
    """The share of exposures with the coded light on; times since the start of the command."""
    periods = math.ceil(float(np.max(end_s, initial=0.0)) / (BIT_S * PERIOD_BITS)) + 1
    bits = np.tile(pattern(), periods).astype(np.float64)
    return lit_share(BIT_S * np.arange(bits.size), bits, start_s, end_s)


@dataclass(frozen=True, kw_only=True)
class CameraFaults:
    """What goes wrong between camera and host; nothing by default.

    So long after the start the stream ends, or freezes; shares of frames that are lost and of
    frames with damaged bytes. Its clock runs fast by ``drift``, and frames come up to ``late_s``
    later than usual.
    """

    seed: int = 0
    ends_s: float = math.inf
    freezes_s: float = math.inf
    lost: float = 0.0
    damaged: float = 0.0
    drift: float = 0.0
    late_s: float = 0.0


class LightCamera:
    """Films a light that is driven by a board, or by ``begin`` and ``end``."""

    def __init__(self, board: StandIn, faults: CameraFaults) -> None:
        self._board, self._faults = board, faults
        self._random = np.random.default_rng(faults.seed)
        self.clock: VirtualClock | None = None
        self._plays: list[tuple[float, float | None]] = []
        self._number = 1
        self._late_s = 0.0
        self._start_s: float | None = None
        self.audience = Audience()

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
        while (due_s := self._due_s()) <= now_s:
            seen_s = now_s - self._start_s
            faults, lost = self._faults, self._random.random() < self._faults.lost
            if self.audience.there and seen_s < min(faults.freezes_s, faults.ends_s):
                if not lost:
                    self.audience.show(self._frame(self._number))
            elif seen_s >= faults.ends_s:
                self.audience.end()
            self._number += 1
            self._late_s = self._faults.late_s * float(self._random.random())
        return due_s

    def _due_s(self) -> float:
        return self._begin_s(self._number) + EXPOSURE_S + 0.02 + self._late_s

    def film(self) -> Iterator[ServedFrame]:
        return self.audience.stream(lambda: self._frame(self._number - 1))

    def _begin_s(self, number: int) -> float:
        return (self._start_s or 0.0) + (number - 1) / RATE_HZ / (1.0 + self._faults.drift)

    def taken_s(self, stamp_s: Array) -> Array:
        """The host's time at the start of exposures (frames,) of which the camera gave the time."""
        start_s = self._start_s or 0.0
        return start_s + (stamp_s - AHEAD_S - start_s) / (1.0 + self._faults.drift)

    def _frame(self, number: int) -> ServedFrame:
        begin_s = self._begin_s(number)
        plays = self._board.plays if isinstance(self._board, BoardStandIn) else self._plays
        share = 0.0
        for start_s, end_s in plays:
            ends_s = begin_s + 1.0 if end_s is None else end_s
            last_s = min(begin_s + EXPOSURE_S, ends_s)
            if last_s > begin_s:
                part = float(seen_share(np.array(begin_s - start_s), np.array(last_s - start_s)))
                share += part * (last_s - begin_s) / EXPOSURE_S
        if self._board.lamp:
            time_s, on = (np.array(column) for column in zip(*self._board.lamp, strict=True))
            ends = np.array([begin_s]), np.array([begin_s + EXPOSURE_S])
            share += float(lit_share(time_s, on * 1.0, *ends)[0])
        image = np.full((64, 96), 60, np.uint8)
        image[16:40, 24:48] += np.uint8(round(150 * min(share, 1.0)))
        data = cv2.imencode(".jpg", image)[1].tobytes()
        if self._random.random() < self._faults.damaged:
            middle = len(data) // 2
            data = data[:middle] + self._random.bytes(20) + data[middle + 20 :]
        passed_s = (begin_s - (self._start_s or 0.0)) * (1.0 + self._faults.drift)
        stamp_s = (self._start_s or 0.0) + passed_s + AHEAD_S
        return ServedFrame(number=number, stamp_s=stamp_s, data=data)


@dataclass(frozen=True, kw_only=True)
class FilmedWire:
    """Devices as a run takes them, and what stands behind them."""

    servo: SupervisedServo
    camera: OpenCamera
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
    camera_faults: CameraFaults | None = None,
    limits: Limits | None = None,
    late_s: float = 0.0,
    keys: str = "",
) -> Iterator[FilmedWire]:
    """A servo of a kind and its camera, each with its faults; ``late_s``: see VirtualClock.

    ``keys`` are further ones of the servo's address.
    """
    far = STAND_INS[kind]()
    wire = Wire(far, faults)
    wrong = camera_faults or CameraFaults()
    film = LightCamera(far, wrong)
    film.clock = clock = VirtualClock([wire, film], late_s, faults.seed if faults else 0)
    # The wait for a picture is in real time: a process may stall for longer than a short one.
    timeout_s = 0.5 if math.isfinite(wrong.freezes_s) else 10.0
    given = Given(exposure_s=EXPOSURE_S, meaning="exposure_start", timeout_s=timeout_s)
    try:
        with MjpegServer(film.film) as server:
            film.pump(clock.now())
            servo = open_servo(f"{kind}:{wire.path}?{KEYS[kind]}{keys}", limits, clock)
            camera = film.audience.attended(open_camera(server.address, given, clock.now))
            yield FilmedWire(servo=servo, camera=camera, far=far, film=film, clock=clock)
            servo.driver.close()
            camera.close()
    finally:
        film.audience.end()
        wire.close()
