"""Dead band of a firmware: no drive within it, all of it outside."""

from __future__ import annotations

from servosight.models.core import Parameter
from servosight.models.effects._band import band_starts
from servosight.models.effects._contract import Effect, Place


def term(drive: float, w: float, half_width: float) -> float:
    """Zero within +-``half_width`` [deg], unchanged from a quarter of it outside.

    Between the two the drive rises along a line: a firmware compares whole steps of its encoder, so
    that its edge lies now here, now there. A jump would make the motion switch without end where
    a weight holds it at the edge.
    """
    beyond = abs(drive) - half_width
    if beyond <= 0.0:
        return 0.0
    if 4.0 * beyond >= half_width:
        return drive
    return 5.0 * beyond if drive > 0.0 else -5.0 * beyond


def switch(drive: float, w: float, half_width: float) -> float:
    """Changes sign where the band ends."""
    return abs(drive) - half_width


def second_switch(drive: float, w: float, half_width: float) -> float:
    """Changes sign where the drive is whole again."""
    return abs(drive) - 1.25 * half_width


def resolution(T: float, half_width: float) -> float:
    """A tenth of the time constant [s]: on the edge the loop is five times as stiff."""
    return 0.1 * T


EFFECT = Effect(
    id="dead_band",
    place=Place.DRIVE,
    parameters=(
        Parameter("half_width", "deg", 0.0, 45.0, 0.0, "position error that causes no torque"),
    ),
    equation="drive = 0 while |e| <= half_width, e where |e| >= 1.25 half_width",
    looks_like="the surface stops anywhere within the half width of the command and coasts there; "
    "large and fast motion is as without it, where a dead zone would lag by its half width",
    cause="dead band in the firmware of a position loop, set to a step or two of its encoder to "
    "prevent hunting",
    confirm="creep the command by 0.05 deg at a time: nothing moves until the half width is "
    "passed, then the surface goes almost all the way; compare steps of 1 and of 10 deg: the error "
    "at rest is the same, the rise is not slower",
    remedy="set the dead band to zero in the servo's registers, or add an integrator",
    source="Feetech STS3215 memory table, addresses 26 and 27 (dead zone of the position loop)",
    starts=band_starts,
    term=term,
    switch=switch,
    second_switch=second_switch,
    resolution=resolution,
)
