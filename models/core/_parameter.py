"""A named physical quantity with bounds, unit and neutral value."""

from __future__ import annotations

import keyword
import math
from dataclasses import dataclass

from servosight.models.base import InputError


@dataclass(frozen=True)
class Scaling:
    """How a value carries over to a recording at another gain of the position loop or load.

    Recordings share one value, at relative gain and load 1; in a recording it is
    ``value * relative_gain**gain * relative_load**load``.
    """

    gain: float = 0.0
    load: float = 0.0

    def factor(self, relative_gain: float, relative_load: float) -> float:
        """What the shared value is multiplied with."""
        return float(relative_gain**self.gain * relative_load**self.load)


FIXED = Scaling()
"""An angle, a speed, a time or a ratio: the same in every recording."""
TORQUE = Scaling(gain=-1.0)
"""A torque in degrees of position error: torque over the stiffness of the loop."""
WEIGHT = Scaling(gain=-1.0, load=1.0)
"""A torque of what hangs on the surface."""


@dataclass(frozen=True)
class Parameter:
    """One number of a model.

    ``neutral`` is the value at which an effect vanishes, or None where the number loses its
    meaning there (a period, a phase). Where ``neutral`` is infinite, the optimiser works on the
    reciprocal, so that files and search space stay finite.

    ``low`` and ``high`` bound the value in its own unit; ``high`` may be infinite only together
    with an infinite ``neutral``. A ``circular`` value begins anew at its bounds, as a phase does:
    the search may pass them by a whole turn. Where ``discontinuous``, a prediction jumps as the
    value changes, and no slope leads to the best one. Where ``free_unit``, the recording chooses
    its unit, and the bounds say nothing of its size.
    """

    name: str
    unit: str
    low: float
    high: float
    neutral: float | None = None
    meaning: str = ""
    scaling: Scaling = FIXED
    circular: bool = False
    discontinuous: bool = False
    free_unit: bool = False

    def __post_init__(self) -> None:
        """Raise InputError, in one sentence, for what no search could use."""
        name, low, high, neutral = self.name, self.low, self.high, self.neutral
        if not (_is_word(name) and not keyword.iskeyword(name)):
            raise InputError(f"parameter {name!r}: expected a name of letters, digits and _")
        for key, value in (("low", low), ("high", high), ("neutral", neutral)):
            if not _is_number(value) and not (key == "neutral" and value is None):
                raise InputError(f"parameter {name}: {key} is {value!r}, expected a number")
        if low > high:
            raise InputError(f"parameter {name}: low is {low:g}, expected at most high, {high:g}")
        if (math.isinf(low) or math.isinf(high)) and not self.reciprocal:
            raise InputError(
                f"parameter {name}: its bounds are {low:g} and {high:g}, expected finite ones, or "
                f"an infinite neutral value as well"
            )
        if neutral is not None and not self.reciprocal and not low <= neutral <= high:
            raise InputError(
                f"parameter {name}: neutral is {neutral:g}, expected a value from low {low:g} to "
                f"high {high:g}"
            )

    @property
    def reciprocal(self) -> bool:
        """True where the optimiser sees 1 / value."""
        return self.neutral is not None and math.isinf(self.neutral)

    @property
    def suffix(self) -> str:
        """The unit behind a value in a sentence, with its space; nothing where it has none."""
        return "" if self.unit == "-" else f" {self.unit}"

    @property
    def range_words(self) -> str:
        """The bounds in words, such as "0.02 to 20" or "0.001 to 2 s"."""
        return f"{self.low:g} to {self.high:g}{self.suffix}"

    def to_search(self, value: float) -> float:
        """Map a physical value to the optimiser's coordinate."""
        if not self.reciprocal:
            return value
        return 0.0 if math.isinf(value) else 1.0 / value

    def from_search(self, coordinate: float) -> float:
        """Map the optimiser's coordinate to the physical value."""
        if self.circular:
            return self.low + (coordinate - self.low) % (self.high - self.low)
        if not self.reciprocal:
            return coordinate
        return math.inf if coordinate == 0.0 else 1.0 / coordinate

    @property
    def search_bounds(self) -> tuple[float, float]:
        """Bounds in the optimiser's coordinate, lower first."""
        if self.circular:
            turn = self.high - self.low
            return self.low - turn, self.high + turn
        if not self.reciprocal:
            return self.low, self.high
        return self.to_search(self.high), self.to_search(self.low)


def _is_word(name: object) -> bool:
    return isinstance(name, str) and name.isidentifier()


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not math.isnan(value)


CORE: tuple[Parameter, ...] = (
    Parameter("k", "-", -10.0, 10.0, meaning="static gain, surface degrees per command degree"),
    Parameter(
        "T",
        "s",
        1e-3,
        2.0,
        meaning="time constant of the position loop",
        scaling=Scaling(gain=-0.5),
    ),
    Parameter("xi", "-", 0.02, 20.0, meaning="damping ratio", scaling=Scaling(gain=-0.5)),
)
"""The linear actuator G(s) = k / (T^2 s^2 + 2 xi T s + 1), paper eq. 1.

Inertia over stiffness is T^2, viscous damping over stiffness 2 xi T: hence the scalings.
"""

OWN: tuple[Parameter, ...] = (
    Parameter("bias", "deg", -720.0, 720.0, meaning="angle at zero command"),
    Parameter("initial_angle", "deg", -720.0, 720.0, meaning="angle at the first instant"),
    Parameter("initial_speed", "deg/s", -1e4, 1e4, meaning="speed at the first instant"),
)
"""What each recording has for itself."""
