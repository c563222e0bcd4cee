"""Units that the names of columns state: ``pos (rad)``, ``t [ms]``, ``goal_rad``, ``time/ms``."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import TypeAlias

from servosight.models.io.tables._series import DEGREES, PULSE, SECONDS

Split: TypeAlias = Callable[[str], tuple[str, str | None]]
"""Tells the name and the unit of a column apart."""
_SPELLINGS = {
    **dict.fromkeys(("sec", "secs", "second", "seconds"), "s"),
    **dict.fromkeys(("msec", "millis", "milliseconds"), "ms"),
    **dict.fromkeys(("µs", "μs", "usec", "micros", "microseconds"), "us"),
    **dict.fromkeys(("nsec", "nanos", "nanoseconds"), "ns"),
    **dict.fromkeys(("mins", "minute", "minutes"), "min"),
    **dict.fromkeys(("hr", "hrs", "hour", "hours"), "h"),
    **dict.fromkeys(("°", "degree", "degrees"), "deg"),
    **dict.fromkeys(("radian", "radians"), "rad"),
    **dict.fromkeys(("turn", "turns", "revolution", "revolutions"), "rev"),
}
"""Other spellings of the units in ``SECONDS`` and ``DEGREES``."""
_KNOWN = frozenset((*SECONDS, *DEGREES, PULSE))
_SIGNAL_UNIT = re.compile(r"[munkµ]?(?:Nm|N|A|V|W)|[cm]N\.?m|kgf?\.?cm|Ncm")
_OF_TIME = re.compile(r"t|(?:.*[^a-z])?time", re.IGNORECASE)
"""Names of clocks; in ``angle_min`` and ``pos_h`` the end is no unit."""
_LABEL = re.compile(r"(?P<name>.*?)(?P<label>(?:\[[^\[\]]*\])*)")
"""A path and the joint or the place in square brackets at its end."""
_BRACKETS = re.compile(r"(?P<name>.*?)\s*(?:\((?P<round>[^()]*)\)|\[(?P<square>[^\[\]]*)\])")


def spelled(unit: str) -> str:
    """A unit as servosight spells it; one that it does not know stays as it is.

    >>> spelled("Degrees"), spelled("counts")
    ('deg', 'counts')
    """
    word = unit.strip()
    return _SPELLINGS.get(word.lower(), word.lower() if word.lower() in _KNOWN else word)


def is_unit(text: str) -> bool:
    """True for a unit of time, of an angle or of a pulse width, in whichever spelling."""
    return spelled(text) in _KNOWN


def split_unit(header: str) -> tuple[str, str | None]:
    """A column's name and the unit that its header writes behind it, None where it writes none.

    Whatever is in brackets is a unit, unless it is a number; behind an underscore or a slash only
    a unit that is known.

    >>> split_unit("pos (rad)"), split_unit("t [ms]"), split_unit("goal_rad"), split_unit("time/ms")
    (('pos', 'rad'), ('t', 'ms'), ('goal', 'rad'), ('time', 'ms'))
    >>> split_unit("pos (counts)"), split_unit("arm/pos"), split_unit("joint[2]")
    (('pos', 'counts'), ('arm/pos', None), ('joint[2]', None))
    >>> split_unit("time_h"), split_unit("angle_min")
    (('time', 'h'), ('angle_min', None))
    """
    found = _BRACKETS.fullmatch(header.strip())
    if found:
        unit = (found["round"] if found["square"] is None else found["square"]).strip()
        if unit and not unit.isdigit():
            return found["name"], spelled(unit)
        return header, None
    return _behind_a_mark(header)


def split_path(path: str) -> tuple[str, str | None]:
    """The same of a path in messages or lists, where square brackets hold a joint or a place.

    >>> split_path("/joint_states.position[elbow]"), split_path("action_rad[elbow]")
    (('/joint_states.position[elbow]', None), ('action[elbow]', 'rad'))
    """
    found = _LABEL.fullmatch(path)
    assert found is not None  # both parts may be empty
    name, unit = _behind_a_mark(found["name"])
    return name + found["label"], unit


def signal_unit(name: str, split: Split = split_unit) -> str | None:
    """The unit in the name of a column that is no angle and no time; None where there is none.

    >>> signal_unit("force (N)"), signal_unit("ext_force_N"), signal_unit("torque_enable")
    ('N', 'N', None)
    >>> signal_unit("/load.torque_Nm[elbow]", split_path), signal_unit("/q.effort[a]", split_path)
    ('Nm', None)
    """
    bare, unit = split(name)
    behind = bare.partition("[")[0].rpartition("_")[2]
    return unit or (behind if _SIGNAL_UNIT.fullmatch(behind) else None)


def _behind_a_mark(name: str) -> tuple[str, str | None]:
    for mark in "_/":
        bare, _, unit = name.rpartition(mark)
        long = spelled(unit) in ("min", "h") and not _OF_TIME.fullmatch(bare)
        if bare and spelled(unit) in _KNOWN and not long:
            return bare, spelled(unit)
    return name, None
