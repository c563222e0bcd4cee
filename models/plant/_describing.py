"""Describing functions: gain and phase of a model for a sine of a given size.

The first harmonic of the angle over that of the command, by simulation: so it holds for every
effect, alone or together, and for effects inside the position loop, whose describing function
depends on the frequency as well (Gelb and Vander Velde, Multiple-Input Describing Functions and
Nonlinear System Design, 1968, chapters 2 and 3).
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from servosight.models.core import Actuator, InputError, Recording
from servosight.models.effects import Effect
from servosight.models.plant._predict import predict

ROWS = 64
"""Rows of the command in a period, joined by lines."""
SAMPLES = 256
"""Samples of the angle in a period: an edge of a rounded command is seen to 1/256 of it."""
TURNED = 0.5
"""Share of a period in which play and friction have turned round once, before the servo settles."""


def describing_function(
    actuator: Actuator,
    amplitude_deg: float,
    frequency_hz: float,
    catalogue: Mapping[str, Effect],
    *,
    offset_deg: float = 0.0,
) -> complex:
    """First harmonic of the angle over that of the command, for a sine of the command.

    ``amplitude_deg`` is that of the command about ``offset_deg``; the phase is the complex number's
    own, negative where the angle lags. Raises InputError unless both numbers are above zero.

    >>> from servosight.models.core import Estimate
    >>> from servosight.models.effects import catalogue
    >>> values = {"k": 1.0, "T": 0.02, "xi": 0.5, "bias": 0.0}
    >>> servo = Actuator({name: Estimate(v, None, "") for name, v in values.items()})
    >>> at_resonance = describing_function(servo, 5.0, 1 / (2 * np.pi * 0.02), catalogue())
    >>> round(abs(at_resonance), 3), round(float(np.degrees(np.angle(at_resonance))), 1)
    (1.0, -90.0)
    """
    for name, value in (("amplitude_deg", amplitude_deg), ("frequency_hz", frequency_hz)):
        if not (math.isfinite(value) and value > 0.0):
            raise InputError(f"describing function: {name} is {value:g}, expected a number above 0")
    period = 1.0 / frequency_hz
    waiting = math.ceil(settling_s(actuator) / period + TURNED)
    turns = np.arange((waiting + 1) * ROWS + 1) / ROWS
    command = offset_deg + amplitude_deg * np.sin(2.0 * np.pi * turns)
    seen = waiting + np.arange(SAMPLES) / SAMPLES
    run = Recording(
        name="sine",
        command_time_s=period * turns,
        command_deg=command,
        time_s=period * np.concatenate([[0.0], seen]),
        angle_deg=np.zeros(seen.size + 1),
        hold="linear",
    )
    start = actuator.value("k") * offset_deg + actuator.value("bias")
    angle = predict(actuator, run, catalogue, initial_angle_deg=start, initial_speed_deg_s=0.0)
    harmonic = 2j * np.mean(angle[1:] * np.exp(-2j * np.pi * seen))
    # Lines between points of a sine have a smaller first harmonic than the sine itself.
    return complex(harmonic / (np.sinc(1.0 / ROWS) ** 2 * amplitude_deg))


def settling_s(actuator: Actuator) -> float:
    """Time [s] after which what a step excites in the linear core, behind its delay, has gone, and
    what an integral has gathered of it."""
    T, xi = actuator.value("T"), actuator.value("xi")
    late = actuator.value("dead_time.delay") if "dead_time" in actuator.effects else 0.0
    return late + 8.0 * (T * max(2.0 * xi, 1.0 / xi) + integral_s(actuator))


def integral_s(actuator: Actuator) -> float:
    """Time constant [s] with which the integral of a controller fades, 0 without one.

    That of the slow pole where rate T is small: -rate / (1 + rate lag).
    """
    found = 0.0
    for effect in {"integral_action", "limited_integral"}.intersection(actuator.effects):
        rate, lag = (actuator.value(f"{effect}.{name}") for name in ("rate", "lag"))
        found = max(found, 1.0 / rate + lag if rate > 0.0 else 0.0)
    return found
