"""A camera on the wire that films the twin: its own clock, drift, latency, jitter, lost frames."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Annotated, Protocol

import numpy as np

from servosight.bench.timing import LightPattern
from servosight.bench.wire import Audience, BoardStandIn, ServedFrame, StandIn
from servosight.models.core import Array, Camera, lit_share, share, within
from servosight.sim.film import LiveFilm, VideoSettings
from servosight.sim.live import LiveTwin

_LONGEST_S = 600.0


@dataclass(frozen=True, kw_only=True)
class CameraFaults:
    """The virtual camera's clock and link: what a rehearsal must not know, and has to find.

    ``clock_s`` is what its clock shows at the start, ``drift`` by how much it runs fast;
    ``latency_s`` from the end of a frame to its delivery, ``jitter_s`` the mean of what comes on
    top (exponentially distributed); ``dropped`` the share of frames that do not arrive.
    """

    clock_s: float = 5000.0
    drift: Annotated[float, within(-1e-3, 1e-3, "")] = 4e-5
    latency_s: Annotated[float, within(0.0, 1.0, "seconds")] = 0.045
    jitter_s: Annotated[float, within(0.0, 1.0, "seconds")] = 0.004
    dropped: Annotated[float, share(0.5)] = 0.01


class Lamp(Protocol):
    """A light in the picture."""

    def share(self, from_s: Array, to_s: Array) -> Array:
        """The share of stretches of time, by the host's clock, in which it is on."""


class BoardLight:
    """The light that a virtual board drives while it plays a command."""

    def __init__(self, board: BoardStandIn, slow_ppm: float) -> None:
        self._board, self._rate = board, 1.0 + 1e-6 * slow_ppm

    def share(self, from_s: Array, to_s: Array) -> Array:
        """The share of stretches of time in which it is on."""
        total = np.zeros(np.shape(from_s))
        for began_s, ended_s in self._board.plays:
            last_s = began_s + _LONGEST_S if ended_s is None else ended_s
            pattern = LightPattern.of_command(began_s, last_s, self._rate)
            total = total + pattern.share(0.5 * (from_s + to_s), float((to_s - from_s).flat[0]))
        return total


class OwnLamp:
    """The light that a virtual servo has, or switches on one of its outputs."""

    def __init__(self, servo: StandIn) -> None:
        self._servo = servo

    def share(self, from_s: Array, to_s: Array) -> Array:
        """The share of stretches of time in which it is on."""
        if not self._servo.lamp:
            return np.zeros(np.shape(from_s))
        time_s, on = (np.array(column) for column in zip(*self._servo.lamp, strict=True))
        return lit_share(time_s, on * 1.0, from_s, to_s)


class VirtualLight:
    """The coded light in the picture, switched by whoever runs the bench."""

    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self._begun_s = float("inf")
        self._ended_s = float("inf")

    def begin(self) -> float:
        """Start the code; the host's time of its first bit, in s."""
        self._begun_s, self._ended_s = self._now(), float("inf")
        return self._begun_s

    def end(self) -> float:
        """Switch the light off; the host's time, in s."""
        self._ended_s = self._now()
        return self._ended_s

    def share(self, from_s: Array, to_s: Array) -> Array:
        """The share of stretches of time in which it is on."""
        if self._begun_s == float("inf"):
            return np.zeros(np.shape(from_s))
        end_s = min(self._ended_s, self._begun_s + _LONGEST_S)
        pattern = LightPattern.of_command(self._begun_s, end_s)
        return pattern.share(0.5 * (from_s + to_s), float((to_s - from_s).flat[0]))


class VirtualCamera:
    """Films the twin frame by frame while time passes (``pump``), for its ``audience``.

    A frame is drawn when it is due for delivery, and only if someone watches. Whoever lets time
    pass waits until the audience has the frame: so a computer that cannot draw in real time only
    takes longer, and no frame is late by the clock of the rehearsal.
    """

    def __init__(
        self,
        twin: LiveTwin,
        camera: Camera,
        faults: CameraFaults,
        light: Lamp,
        *,
        seed: int,
    ) -> None:
        self._twin, self._camera, self._faults, self._light = twin, camera, faults, light
        self._start_s = 0.0
        settings = VideoSettings(texture_seed=seed % 1000, workers=1)
        self._film = LiveFilm(camera, settings, seed)
        self._random = np.random.default_rng([seed, 77])
        self._number = 1
        self._late_s = self._draw_late_s()
        self.audience = Audience()

    def start(self, start_s: float) -> None:
        """Begin; ``start_s`` is the host's time at which the twin's own time is 0."""
        self._start_s = start_s

    def pump(self, now_s: float) -> float:
        """Deliver the frames that are due by now; the time of the next delivery."""
        while (due_s := self._delivery_s()) <= now_s:
            lost = self._random.random() < self._faults.dropped
            if self.audience.there and not lost:
                self.audience.show(self._frame(self._number))
            self._number += 1
            self._late_s = self._draw_late_s()
        return due_s

    def film(self) -> Iterator[ServedFrame]:
        """The frames for one who watches: the last one at once, then each as it is delivered."""
        return self.audience.stream(lambda: self._frame(self._number - 1))

    def begin_s(self, number: int) -> float:
        """Start of a frame's exposure on the host's clock: what the bench has to find."""
        period_s = 1.0 / (self._camera.rate_hz * (1.0 + self._faults.drift))
        return self._start_s + (number - 1) * period_s

    def stamp_s(self, number: int) -> float:
        """The time that the camera gives a frame: the start of its exposure, by its own clock."""
        faults = self._faults
        return faults.clock_s + (self.begin_s(number) - self._start_s) * (1.0 + faults.drift)

    def _delivery_s(self) -> float:
        camera = self._camera
        taken_s = self.begin_s(self._number) + camera.exposure_s + camera.readout_s
        return taken_s + self._faults.latency_s + self._late_s

    def _draw_late_s(self) -> float:
        return float(self._random.exponential(self._faults.jitter_s or 1e-12))

    def _frame(self, number: int) -> ServedFrame:
        begin_s, start_s = self.begin_s(number), self._start_s

        def lit(from_s: Array, to_s: Array) -> Array:
            return self._light.share(from_s + start_s, to_s + start_s)

        data = self._film.jpeg(number, begin_s - start_s, self._twin.between, lit)
        return ServedFrame(number=number, stamp_s=self.stamp_s(number), data=data)
