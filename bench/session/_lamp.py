"""A light in the picture that the host switches over the servo's own line: the code, edge by edge.

The host is late by what it is busy with, so the light does not follow the code to the millisecond.
It need not: each switching is noted when it happens, and the pattern that is looked for in the
picture is made of these times.
"""

from __future__ import annotations

import math

import numpy as np

from servosight.bench.host_clock import Clock
from servosight.bench.light import BIT_S, PERIOD_BITS, pattern
from servosight.bench.servo import Lamp
from servosight.bench.timing import LightPattern


class CodedLamp:
    """Switches a lamp by the coded light while the run waits; ``begin``, ``wait``, ``end``."""

    def __init__(self, lamp: Lamp, clock: Clock) -> None:
        self._lamp, self._clock = lamp, clock
        self._begun_s = math.inf
        self._due_s = math.inf
        self._times: list[float] = []
        self._states: list[bool] = []

    @property
    def sigma_s(self) -> float:
        """Standard deviation of when it really switches [s]."""
        return self._lamp.sigma_s

    @property
    def switched(self) -> LightPattern | None:
        """When it was on, by the host's clock; None before it began."""
        if not self._times:
            return None
        return LightPattern(time_s=np.array(self._times), states=np.array(self._states) * 1.0)

    def begin(self) -> None:
        """Start the code."""
        self._begun_s = self._clock.now()
        self._follow()

    def wait(self, until_s: float) -> None:
        """Wait until a time, and switch on the way."""
        while self._due_s < until_s:
            self._clock.wait(self._due_s)
            self._follow()
        self._clock.wait(until_s)

    def end(self) -> None:
        """Switch it off."""
        self._due_s = math.inf
        if self._times:
            self._switch(False)

    def _follow(self) -> None:
        """Switch it as the code is now, and find out when it changes."""
        bits = pattern()
        bit = math.floor((self._clock.now() - self._begun_s) / BIT_S + 1e-6)
        wanted = bool(bits[bit % PERIOD_BITS])
        if not self._states or self._states[-1] != wanted:
            self._switch(wanted)
        while bits[bit % PERIOD_BITS] == wanted:
            bit += 1
        self._due_s = self._begun_s + bit * BIT_S

    def _switch(self, on: bool) -> None:
        self._times.append(self._lamp.switch(on))
        self._states.append(on)
