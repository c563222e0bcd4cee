"""Which servo a compound trial has, and how it is logged; drawn by a name.

Everything comes from hashes of the trial's name and of what is drawn: a new effect in a family
leaves what is drawn for the others as it is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from hashlib import sha256

import numpy as np

from .servo import ENCODER_DEG, Servo

Span = tuple[float, float]

HIDDEN = (3, 6)
"""Fewest and most effects of a servo; dead time, which every polled bus has, is not counted."""
RATES_HZ: Span = (50.0, 200.0)


@dataclass(frozen=True)
class Mechanism:
    """Something that real servos have: the numbers of :class:`Servo` that it sets, and its id.

    ``ranges`` are drawn evenly on a logarithmic scale; a range of equal ends is a constant.
    """

    effect: str
    ranges: Mapping[str, Span]
    chance: float = 0.5


@dataclass(frozen=True)
class ServoFamily:
    """Servos of one kind: the linear part at the lowest gain, relative gains, what may be in them.

    Of mechanisms in one group at most one is present.
    """

    T: Span
    xi: Span
    gains: tuple[float, ...]
    amplitude_deg: Span
    fast_hz: Span
    groups: tuple[tuple[Mechanism, ...], ...]


def _gravity(sine: Span) -> Mechanism:
    return Mechanism("gravity_load", {"sine": sine}, 0.7)


COULOMB = Mechanism("coulomb_friction", {"friction": (1.0, 4.0)}, 0.4)
STRIBECK = Mechanism(
    "stribeck_friction",
    {"friction": (0.6, 2.0), "excess": (1.0, 3.0), "stribeck_speed": (8.0, 40.0)},
    0.45,
)
LOAD = Mechanism("load_dependent_friction", {"motor_ratio": (0.12, 0.35)}, 0.35)
DIRECTIONAL = Mechanism(
    "directional_friction", {"motor_ratio": (0.05, 0.2), "load_ratio": (0.1, 0.3)}, 0.25
)


def _limited(limit: Span, chance: float) -> tuple[Mechanism, ...]:
    """The duty ends at the supply's voltage, or the current is limited."""
    return (
        Mechanism("torque_saturation", {"voltage": limit}, 0.6 * chance),
        Mechanism("current_limit", {"current": limit}, 0.4 * chance),
    )


def _profile(top_speed: Span, chance: float) -> tuple[Mechanism, ...]:
    """The firmware's reference moves no faster than this; half of them limit acceleration, too."""
    limits = {"top_speed": top_speed, "acceleration": (8.0 * top_speed[0], 8.0 * top_speed[1])}
    return (
        Mechanism("rate_limit", {"top_speed": top_speed}, 0.5 * chance),
        Mechanism("motion_profile", limits, 0.5 * chance),
    )


FAMILIES: Mapping[str, ServoFamily] = {
    # As XL330, MX-64: a pendulum on a weak loop, gravity of tens of degrees.
    "pendulum": ServoFamily(
        (0.05, 0.14),
        (0.45, 1.0),
        (1.0, 2.0, 4.0),
        (50.0, 90.0),
        (0.8, 2.0),
        (
            (_gravity((15.0, 70.0)),),
            (LOAD, DIRECTIONAL),
            (COULOMB, STRIBECK),
            _limited((20.0, 60.0), 0.6),
            _profile((120.0, 300.0), 0.3),
        ),
    ),
    # As STS3215: a stiff loop with a slew limit and a dead band in its firmware.
    "bus servo": ServoFamily(
        (0.02, 0.05),
        (0.5, 1.1),
        (1.0, 2.0),
        (30.0, 60.0),
        (1.0, 3.0),
        (
            _profile((100.0, 350.0), 0.6),
            (Mechanism("dead_band", {"dead_band": (1.0, 2.49)}, 0.6),),
            (_gravity((10.0, 40.0)),),
            (LOAD, DIRECTIONAL),
            (COULOMB, STRIBECK),
            _limited((8.0, 25.0), 0.6),
        ),
    ),
    # As hobby servos: a potentiometer on gears with play.
    "hobby servo": ServoFamily(
        (0.015, 0.035),
        (0.6, 1.1),
        (1.0,),
        (20.0, 45.0),
        (1.0, 4.0),
        (
            (Mechanism("feedback_backlash", {"play": (0.8, 3.0)}, 0.8),),
            (Mechanism("dead_band", {"dead_band": (2.0, 6.0)}, 0.5),),
            (_gravity((8.0, 30.0)),),
            (COULOMB, STRIBECK),
            (Mechanism("torque_saturation", {"voltage": (5.0, 15.0)}, 0.7),),
        ),
    ),
}


@dataclass(frozen=True)
class Bus:
    """How a host logs: poll rate, latencies of reading and writing, jitters [s], noise [deg].

    ``repeated`` and ``glitched`` are shares of the samples.
    """

    rate_hz: float
    read_s: float
    write_s: float
    poll_jitter_s: float
    stamp_jitter_s: float
    noise_deg: float
    repeated: float
    glitched: float


@dataclass(frozen=True)
class CompoundSetup:
    """A servo with its gains, and the host that logs it."""

    seed: int
    attempt: int
    family: str
    servo: Servo
    hidden: tuple[str, ...]
    gains: tuple[float, ...]
    amplitude_deg: float
    bus: Bus

    def rng(self, *what: object) -> np.random.Generator:
        """A source of random numbers for one thing of this trial."""
        return rng_of("compound", self.seed, self.attempt, *what)

    @property
    def truth(self) -> dict[str, float]:
        """The catalogue's parameters that come nearest to this servo, at a relative gain of 1."""
        p = self.servo
        T = math.sqrt(p.inertia)
        every = {
            "dead_time.delay": self.bus.read_s + self.bus.write_s + 0.5 * p.loop_s,
            "rate_limit.rate": p.top_speed,
            # Whole steps of goal and angle differ by more than the band from half a step on.
            "dead_band.half_width": (max(p.dead_band, 0.0) + 0.5) * ENCODER_DEG / 1.125,
            "motion_profile.rate": p.top_speed,
            "motion_profile.acceleration": p.acceleration,
            "torque_saturation.limit": p.voltage,
            "current_limit.limit": p.current,
            "current_limit.back_emf": p.back_emf,
            "coulomb_friction.level": p.friction,
            "stribeck_friction.level": p.friction,
            "stribeck_friction.excess": p.excess,
            "stribeck_friction.speed": p.stribeck_speed,
            "load_dependent_friction.ratio": p.motor_ratio,
            "directional_friction.motor": p.motor_ratio,
            "directional_friction.outer": p.load_ratio,
            "directional_friction.back_emf": p.back_emf,
            "gravity_load.sine": p.sine,
            "gravity_load.cosine": p.cosine,
            "feedback_backlash.gap": p.play,
        }
        core = {"k": 1.0, "T": T, "xi": 0.5 * (p.viscous + p.back_emf) / T}
        return core | {k: v for k, v in every.items() if k.split(".")[0] in self.effects}

    @property
    def effects(self) -> tuple[str, ...]:
        """What is hidden, and the dead time of bus and firmware."""
        return ("dead_time", *self.hidden)


def rng_of(*names: object) -> np.random.Generator:
    """A source of random numbers that depends on these names alone."""
    digest = sha256(" ".join(map(str, names)).encode()).digest()
    return np.random.default_rng(int.from_bytes(digest[:16], "little"))


def propose(seed: int, attempt: int) -> CompoundSetup:
    """The ``attempt``-th draw of a trial's servo. Families take turns with the seed."""

    def draw(what: str) -> np.random.Generator:
        return rng_of("compound", seed, attempt, what)

    name = sorted(FAMILIES)[seed % len(FAMILIES)]
    family = FAMILIES[name]
    T, xi = between(draw("T"), family.T), between(draw("xi"), family.xi)
    share = float(draw("back-EMF").uniform(0.1, 0.5))
    numbers = {
        "inertia": T * T,
        "back_emf": 2.0 * xi * T * share,
        "viscous": 2.0 * xi * T * (1.0 - share),
        "loop_s": float(draw("loop").choice((5e-4, 1e-3, 2e-3))),
    }
    hidden = _present(family, draw)
    for one in hidden:
        for key, span in one.ranges.items():
            numbers[key] = between(draw(f"{one.effect} {key}"), span)
    if "dead_band" in numbers:
        numbers["dead_band"] = float(math.floor(numbers["dead_band"]))
    bus = Bus(
        rate_hz=between(draw("rate"), RATES_HZ),
        read_s=between(draw("read"), (5e-4, 4e-3)),
        write_s=between(draw("write"), (5e-4, 8e-3)),
        poll_jitter_s=between(draw("poll"), (1e-4, 1e-3)),
        stamp_jitter_s=between(draw("stamp"), (2e-5, 4e-4)),
        noise_deg=between(draw("noise"), (0.01, 0.04)),
        repeated=float(draw("repeated").uniform(0.0, 0.1)),
        glitched=float(draw("glitched").uniform(0.0, 0.004)),
    )
    several = draw("gains").permutation(family.gains)[: 1 + int(draw("several").random() < 0.5)]
    return CompoundSetup(
        seed,
        attempt,
        name,
        Servo(**numbers),
        tuple(one.effect for one in hidden),
        tuple(sorted(float(gain / several.min()) for gain in several)),
        between(draw("amplitude"), family.amplitude_deg),
        bus,
    )


def _present(family: ServoFamily, draw: Callable[[str], np.random.Generator]) -> list[Mechanism]:
    """Mechanisms of the servo: each group by its chance, the likeliest until there are three."""
    ranked = []
    for group in family.groups:
        names = " ".join(one.effect for one in group)
        choice, luck = draw(f"present {names}").random(2)
        edges = np.cumsum([one.chance for one in group])
        total = float(edges[-1])
        one = group[int(np.searchsorted(edges, choice * total))]
        ranked.append((luck / total, luck, one))
    ranked.sort(key=lambda each: each[0])
    least, most = HIDDEN
    wanted = sum(score < 1.0 for score, _, _ in ranked)
    return [one for _, _, one in ranked[: min(max(wanted, least), most)]]


def between(rng: np.random.Generator, span: Span) -> float:
    """A number from ``span``, drawn evenly on a logarithmic scale."""
    low, high = span
    return float(low * (high / low) ** rng.random())
