"""Numbers as people read them."""

from __future__ import annotations

import math

DIGITS = 3
MOST_DECIMALS = 8
LARGEST = 1e7
"""No parameter of a servo is as large, in its unit."""


def rounded(value: float, digits: int = DIGITS) -> str:
    """``digits`` significant digits without an exponent where that stays short."""
    if value == 0.0 or not math.isfinite(value):
        return "0" if value == 0.0 else str(value)
    decimals = digits - 1 - math.floor(math.log10(abs(value)))
    if decimals > MOST_DECIMALS:
        return f"{value:.{digits - 1}e}".replace("-", "−")
    return f"{round(value, decimals):.{max(decimals, 0)}f}".replace("-", "−")


def degrees(value: float, digits: int = DIGITS) -> str:
    """An angle with its unit."""
    return f"{rounded(value, digits)} deg"


def signed(value: float, decimals: int = 2) -> str:
    """A number with its sign in any case."""
    return f"{value:+.{decimals}f}".replace("-", "−")


def times(ratio: float) -> str:
    """How many times, to two digits."""
    return rounded(ratio, 2)


def percent(value: float) -> str:
    """A percentage with as many digits as show how far below 100 it is."""
    off = abs(100.0 - value)
    decimals = 0 if off >= 10.0 else 1 if off >= 1.0 else 2 if off >= 0.1 else 3
    return f"{value:.{decimals}f}".replace("-", "−")


def chance(p: float) -> str:
    """A probability as tests state it."""
    return "p < 0.001" if p < 1e-3 else f"p = {p:.2g}"


def uncertain(value: float, sigma: float | None) -> tuple[str, str]:
    """A value to the digits that its sigma supports, and the sigma to two digits.

    A sigma of 0 is that of a parameter that was held. A value without one that is as large as no
    servo's is a limit that was not reached.

    >>> uncertain(2.4961, 0.0103), uncertain(4.9e9, None)
    (('2.496', '0.010'), ('not reached', 'not known'))
    """
    if sigma == 0.0:
        return rounded(value, 4), "held"
    if sigma is None or sigma < 0.0 or not math.isfinite(sigma):
        return "not reached" if value > LARGEST else rounded(value, 4), "not known"
    decimals = min(max(1 - math.floor(math.log10(sigma)), 0), MOST_DECIMALS)
    return f"{value:.{decimals}f}".replace("-", "−"), f"{sigma:.{decimals}f}"
