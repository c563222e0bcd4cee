"""Supply voltage that drops under load."""

from __future__ import annotations

from servosight.models.core import Parameter, Scaling
from servosight.models.effects._contract import Effect, GuessFeatures, Place


def term(drive: float, w: float, state: float, sag: float, time: float) -> tuple[float, float]:
    """Drive [deg] weakened by its own filtered size ``state`` [deg], and that state's rate."""
    # A quotient of parameters alone is worked out once, before the steps.
    return drive * max(1.0 - sag * state, 0.0), (abs(drive) - state) * (1.0 / time)


def switch(drive: float, w: float, state: float, sag: float, time: float) -> float:
    """Changes sign with the drive, whose size has its corner there."""
    return drive


def resolution(sag: float, time: float) -> float:
    """Longest step [s] that follows the supply."""
    return 0.3 * time


def starts(features: GuessFeatures) -> tuple[tuple[float, ...], ...]:
    """A third gone at the largest drive, fast and slow."""
    return tuple(
        (share / features.drive_deg, time)
        for share, time in ((0.3, 0.05), (1.0, 0.2), (2.0, 1.0), (1.0, 0.02))
    )


EFFECT = Effect(
    id="supply_sag",
    place=Place.DRIVE,
    parameters=(
        Parameter("sag", "1/deg", 0.0, 10.0, 0.0, "share lost for each degree", Scaling(gain=1.0)),
        Parameter("time", "s", 2e-3, 20.0, None, "time constant of the voltage drop"),
    ),
    equation="drive = e (1 - sag s), time ds/dt = |e| - s",
    looks_like="after hard work the servo is slower than before it, and recovers while it rests; "
    "the first of several quick steps is the fastest",
    cause="battery, long thin leads, a regulator at its limit",
    confirm="watch the supply voltage at the servo during quick steps; shorten the leads or add a "
    "large capacitor: the loss shrinks",
    remedy="shorter and thicker leads, a capacitor at the servo, a stronger battery",
    source="Chen and Rincon-Mora, IEEE Trans. Energy Conversion 21(2) (2006): resistance and "
    "first-order transient of a battery",
    starts=starts,
    term=term,
    switch=switch,
    resolution=resolution,
    states=1,
)
