"""Dead band of the drive."""

from __future__ import annotations

from servosight.models.core import Parameter
from servosight.models.effects._band import band_starts
from servosight.models.effects._contract import Effect, Place


def term(drive: float, w: float, half_width: float) -> float:
    """Zero within +-``half_width`` [deg], shifted outside."""
    if drive > half_width:
        return drive - half_width
    if drive < -half_width:
        return drive + half_width
    return 0.0


def switch(drive: float, w: float, half_width: float) -> float:
    """Changes sign at the upper end of the band."""
    return drive - half_width


def second_switch(drive: float, w: float, half_width: float) -> float:
    """Changes sign at its lower end: a step of the command may pass both."""
    return drive + half_width


EFFECT = Effect(
    id="dead_zone",
    place=Place.DRIVE,
    parameters=(
        Parameter("half_width", "deg", 0.0, 45.0, 0.0, "position error that causes no torque"),
    ),
    equation="drive = e - clip(e, -half_width, half_width)",
    looks_like="the surface stops short of the command by up to the half width and coasts there "
    "without sticking; slow motion lags by a constant angle",
    cause="dead band of the pulse-width input or of the amplifier, set to prevent hunting",
    confirm="creep the command by 0.1 deg at a time: nothing moves until the half width is passed; "
    "push by hand: inside the band the surface yields freely",
    remedy="reduce the dead band in the servo's settings, or add an integrator",
    source="Tao and Kokotovic, Adaptive Control of Systems with Actuator and Sensor "
    "Nonlinearities (1996), chapter 2",
    starts=band_starts,
    term=term,
    switch=switch,
    second_switch=second_switch,
)
