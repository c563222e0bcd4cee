"""A bench without hardware: a servo on a pseudo-terminal and a camera on the loopback interface."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

import numpy as np
from msgspec import Meta

from servosight.bench.camera import Given, OpenCamera, open_camera
from servosight.bench.host_clock import HOST
from servosight.bench.wire import (
    BoardStandIn,
    DynamixelStandIn,
    FeetechStandIn,
    MaestroStandIn,
    MjpegServer,
    Plant,
    StandIn,
    VirtualClock,
    Wire,
    serving,
)
from servosight.models.core import Camera, check_seed
from servosight.scenarios.draws import DRAWS
from servosight.scenarios.rehearsal._camera import (
    BoardLight,
    CameraFaults,
    Lamp,
    OwnLamp,
    VirtualCamera,
    VirtualLight,
)
from servosight.scenarios.settings import LinearServo
from servosight.sim.effects import resolve
from servosight.sim.live import LiveTwin

Kind = Literal["board", "dynamixel", "feetech", "maestro"]
HIDDEN = ("backlash", "coulomb_friction", "dead_zone", "asymmetric_gain")
"""Effects that a rehearsal may hide: each shows in a film of ten seconds."""
SLOW_PPM = 800.0
"""By how much the virtual board's resonator runs slow."""
PULSE_S = 0.020006
"""Pulse period of the virtual Maestro, whose crystal runs slow by 300 ppm."""
CAMERA = Camera(rate_hz=60.0, exposure_s=0.003, width=320, height=240)
_KEYS = {
    "board": "",
    "dynamixel": "id=1&baud=57600&light=led",
    "feetech": "id=1",
    "maestro": "crc=true&light_channel=5",
}


@dataclass(frozen=True, kw_only=True)
class Rehearsal:
    """What stands on the virtual bench: a servo with hidden effects, and a camera."""

    seed: Annotated[int, Meta(ge=0, description="a whole number from 0")] = 0
    kind: Kind = "dynamixel"
    servo: LinearServo = field(default_factory=LinearServo)
    effects: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    camera: Camera = CAMERA
    faults: CameraFaults = field(default_factory=CameraFaults)

    @classmethod
    def drawn(cls, seed: int, kind: Kind = "dynamixel") -> Rehearsal:
        """A servo with one hidden effect, and a camera's clock, as ``seed`` draws them.

        Raises InputError for a seed that is no whole number from 0.
        """
        check_seed(seed)
        rng = np.random.default_rng([seed, 19])
        effect = HIDDEN[int(rng.integers(len(HIDDEN)))]
        ranges = DRAWS[effect]
        values = {name: float(rng.uniform(*span)) for name, span in ranges.parameters.items()}
        servo = LinearServo(
            k=float(rng.uniform(0.85, 1.1)),
            T=float(rng.uniform(0.02, 0.03)),
            xi=float(rng.uniform(0.5, 0.8)),
        )
        faults = CameraFaults(
            clock_s=float(rng.uniform(0.0, 1e4)),
            drift=float(rng.uniform(-8e-5, 8e-5)),
            latency_s=float(rng.uniform(0.02, 0.09)),
        )
        return cls(seed=seed, kind=kind, servo=servo, effects={effect: values}, faults=faults)

    def truth(self) -> dict[str, Any]:
        """What is hidden, for scoring: effects, parameters, the camera's clock."""
        values = {
            f"{effect}.{name}": value
            for effect, table in resolve(self.effects).items()
            for name, value in table.items()
        }
        core = {"k": self.servo.k, "T": self.servo.T, "xi": self.servo.xi}
        return {
            "format": 1,
            "effects": list(self.effects),
            "parameters": {**core, "bias": self.servo.bias, **values},
            "camera": {"drift": self.faults.drift, "latency_s": self.faults.latency_s},
        }


@dataclass(frozen=True, kw_only=True)
class VirtualBench:
    """Addresses as a user would type them, and the clock by which time passes.

    ``light`` is None where the servo or its board has one.
    """

    servo: str
    camera: str
    light: VirtualLight | None
    clock: VirtualClock
    film: VirtualCamera
    stand_in: StandIn

    def open_camera(self, given: Given) -> OpenCamera:
        """The camera at its address; time stands still while what reads it is busy with a frame."""
        return self.film.audience.attended(open_camera(self.camera, given, self.clock.now))


@contextmanager
def virtual_bench(rehearsal: Rehearsal) -> Iterator[VirtualBench]:
    """Stand a servo and a camera on the wire for the body of a ``with``.

    Time passes while somebody waits on ``clock``, and waits for the pictures to be drawn and read:
    a rehearsal takes as long as the computer needs, and is the same each time.
    """
    pumped: list[Any] = []
    clock = VirtualClock(pumped)
    with _devices(rehearsal, clock.now) as (wire, film, light, address):
        pumped += [wire, film]
        yield VirtualBench(
            servo=f"{rehearsal.kind}:{wire.path}?{_KEYS[rehearsal.kind]}",
            camera=address,
            light=light,
            clock=clock,
            film=film,
            stand_in=wire.servo,
        )


@contextmanager
def served_bench(rehearsal: Rehearsal) -> Iterator[tuple[str, str]]:
    """Addresses of a servo and a camera that live in real time, for other programs to use.

    A Feetech servo has no light that another program could switch; the others have. A computer
    that draws too slowly delivers frames late; their stamps are right all the same.
    """
    with _devices(rehearsal, HOST.now) as (wire, film, _, address), serving(wire), serving(film):
        yield f"{rehearsal.kind}:{wire.path}?{_KEYS[rehearsal.kind]}", address


@contextmanager
def _devices(
    rehearsal: Rehearsal, now: Callable[[], float]
) -> Iterator[tuple[Wire, VirtualCamera, VirtualLight | None, str]]:
    """Wire, camera, the light of a servo that has none, and the camera's address."""
    twin = LiveTwin(rehearsal.servo.bench(), rehearsal.effects)
    stand_in = _stand_in(rehearsal.kind, twin)
    wire = Wire(stand_in)
    light = VirtualLight(now) if rehearsal.kind == "feetech" else None
    lamp: Lamp = light or OwnLamp(stand_in)
    if isinstance(stand_in, BoardStandIn):
        lamp = BoardLight(stand_in, SLOW_PPM)
    film = VirtualCamera(twin, rehearsal.camera, rehearsal.faults, lamp, seed=rehearsal.seed)
    start_s = now()
    stand_in.advance(start_s)
    film.start(start_s)
    try:
        with MjpegServer(film.film) as server:
            yield wire, film, light, server.address
    finally:
        film.audience.end()
        wire.close()


def _stand_in(kind: Kind, plant: Plant) -> StandIn:
    if kind == "board":
        return BoardStandIn(plant, SLOW_PPM)
    if kind == "dynamixel":
        return DynamixelStandIn(plant)
    if kind == "feetech":
        return FeetechStandIn(plant)
    return MaestroStandIn(plant, crc=True, period_s=PULSE_S)
