"""Where a servo is, as the user types it: ``dynamixel:/dev/ttyUSB0?id=1&baud=57600``."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from urllib.parse import parse_qsl

from servosight.models.core import InputError, did_you_mean


@dataclass(frozen=True, kw_only=True)
class Address:
    """The kind of servo, its port and the keys behind the question mark."""

    text: str
    kind: str
    path: str
    keys: dict[str, object]


def read_address(text: str, kinds: Iterable[str]) -> Address:
    """Read an address; InputError for one that is none.

    >>> address = read_address("maestro:/dev/ttyACM0?channel=2&crc=true", ["maestro"])
    >>> address.path, address.keys
    ('/dev/ttyACM0', {'channel': 2, 'crc': True})
    """
    kind, colon, rest = text.partition(":")
    path, _, query = rest.partition("?")
    known = sorted(kinds)
    if not colon or not path:
        raise InputError(
            f"{text!r} is no address of a servo, expected KIND:PORT?KEY=VALUE such as "
            f"dynamixel:/dev/ttyUSB0?id=1; KIND is one of {', '.join(known)}"
        )
    if kind not in known:
        raise InputError(
            f"{text!r}: unknown kind of servo {kind!r}{did_you_mean(kind, known)}, expected one of "
            f"{', '.join(known)}; correct the address"
        )
    try:
        pairs = parse_qsl(query, keep_blank_values=True, strict_parsing=bool(query))
    except ValueError as error:
        raise InputError(
            f"{text!r}: {query!r} are no keys and values, expected KEY=VALUE&KEY=VALUE; correct "
            f"the address"
        ) from error
    return Address(text=text, kind=kind, path=path, keys={key: _value(one) for key, one in pairs})


def _value(text: str) -> object:
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text
