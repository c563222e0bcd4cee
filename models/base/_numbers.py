"""Numbers that a user gives to several functions, refused in one place where they cannot be."""

from __future__ import annotations

from numbers import Integral, Real

from servosight.models.base._errors import InputError

LARGEST_ERROR_DEG = 1e6
"""No error of an angle comes near this."""


def check_seed(seed: object) -> None:
    """InputError where ``seed`` is no whole number from 0.

    >>> check_seed(-1)
    Traceback (most recent call last):
    servosight.models.base._errors.InputError: seed is -1, expected a whole number from 0; ...
    """
    if not isinstance(seed, Integral) or int(seed) < 0:
        raise InputError(f"seed is {seed}, expected a whole number from 0; choose one, such as 3")


def check_tolerance(tolerance_deg: object) -> None:
    """InputError where ``tolerance_deg`` is no error of an angle [deg].

    >>> check_tolerance(float("nan"))
    Traceback (most recent call last):
    servosight.models.base._errors.InputError: tolerance is nan, expected degrees from 0 to ...
    """
    if not isinstance(tolerance_deg, Real) or not 0.0 <= float(tolerance_deg) <= LARGEST_ERROR_DEG:
        raise InputError(
            f"tolerance is {tolerance_deg}, expected degrees from 0 to {LARGEST_ERROR_DEG:g}; "
            f"leave it out for 0.05 % of the moved range"
        )
