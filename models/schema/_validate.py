"""Tables as users write them, read into frozen dataclasses, with one sentence for what is wrong.

The annotation of a field says what its key may hold: its type, and with :func:`within` or a
``msgspec.Meta`` of its own the range. Every message names the file, the key, what was expected and
how to fix it.
"""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Callable, Collection, Mapping
from functools import cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

import msgspec

from servosight.models.base import InputError, shown

T = TypeVar("T")

APART = msgspec.Meta(extra={"apart": True})
"""Marks a field that has no key of its own."""

_WORDS = {float: "a finite number", int: "a whole number", bool: "true or false", str: "a text"}
_FIX = "correct that value"
_ALIKE = 0.8
"""Similarity (difflib) from which an unknown key passes for a misspelt one."""


def within(low: float, high: float, unit: str, fix: str = _FIX) -> msgspec.Meta:
    """The range of a number, for ``Annotated[float, within(0.0, 1.0, "seconds")]``."""
    span = f"{low:g} or more" if math.isinf(high) else f"{low:g} to {high:g}"
    return msgspec.Meta(
        ge=low,
        le=None if math.isinf(high) else high,
        description=f"{span} {unit}".strip(),
        extra={"fix": fix},
    )


def share(highest: float = 1.0) -> msgspec.Meta:
    """The range of a share."""
    return msgspec.Meta(
        ge=0.0,
        le=highest,
        description=f"a share of 0 to {highest:g}",
        extra={"fix": "write 5 % as 0.05"},
    )


def validated(
    table: Any,
    kind: type[T],
    source: Path | str,
    section: str = "",
    *,
    others: Collection[str] = (),
    notes: bool = False,
) -> T:
    """Make a ``kind``, a dataclass, from the keys of ``table``; what is absent keeps its default.

    ``source`` names the file and ``section`` the table in messages. Keys in ``others`` are read
    elsewhere. With ``notes`` the user may have keys of their own, but none that looks like a
    misspelt one; without, every unknown key is refused. Raises InputError.

    >>> @dataclasses.dataclass(frozen=True)
    ... class Lamp:
    ...     share: Annotated[float, within(0.0, 1.0, "of the light")] = 0.5
    >>> validated({"share": 1}, Lamp, "a.toml")
    Lamp(share=1.0)
    >>> validated({"share": 2.5}, Lamp, "a.toml", "lamp")
    Traceback (most recent call last):
    servosight.models.base._errors.InputError: a.toml: key lamp.share is 2.5, expected 0 to 1 ...
    """
    if not isinstance(table, Mapping):
        raise InputError(
            f"{source}: {f'key {section} ' if section else ''}is {_shown(table)}, expected a "
            f"table; write {f'[{section}]' if section else 'one'} and its keys below"
        )
    prefix = f"{section}." if section else ""
    hints = _hints(kind)  # type: ignore[arg-type]
    _check_keys(table, [*hints, *others], source, prefix, notes)
    values = {
        name: _value(table[name], hint, source, prefix + name, notes)
        for name, hint in hints.items()
        if name in table and name not in others
    }
    for field in dataclasses.fields(kind):  # type: ignore[arg-type]
        lacks = field.default is field.default_factory is dataclasses.MISSING
        if lacks and field.name in hints and field.name not in values:
            expected, fix = _words(hints[field.name])
            fix = "add it" if fix == _FIX else fix
            raise InputError(
                f"{source}: key {prefix}{field.name} is missing, expected {expected}; {fix}"
            )
    return kind(**values)


def check_fields(
    instance: Any, source: Path | str, section: str = "", given_as: Callable[[str], str] = str
) -> None:
    """Hold the values of a dataclass to its annotations, as if a file had them; InputError.

    ``given_as`` says how the user names a key that need not come from a file.
    """
    for name, hint in get_type_hints(type(instance), include_extras=True).items():
        value, key = getattr(instance, name), f"{section}.{name}" if section else name
        if dataclasses.is_dataclass(value):
            check_fields(value, source, section if _is_apart(hint) else key, given_as)
        elif not _is_apart(hint):
            _value(value, hint, source, given_as(key))


def validated_value(value: Any, kind: Any, source: Path | str, key: str) -> Any:
    """One value as a ``kind``, such as float; InputError that ``key`` in ``source`` is none."""
    return _value(value, kind, source, key)


def require(holds: bool, source: Path | str, key: str, value: object, expected: str) -> None:
    """Raise InputError that ``key`` is ``value`` and what was ``expected``, unless it holds."""
    if not holds:
        raise InputError(f"{source}: key {key} is {_shown(value)}, expected {expected}; {_FIX}")


@cache
def _hints(kind: type) -> dict[str, Any]:
    """The annotations of the fields that have a key."""
    hints = get_type_hints(kind, include_extras=True)
    own = (field.name for field in dataclasses.fields(kind))
    return {name: hints[name] for name in own if not _is_apart(hints[name])}


def _check_keys(
    table: Mapping[str, Any], known: list[str], source: Path | str, prefix: str, notes: bool
) -> None:
    for key in table:
        if key in known:
            continue
        alike = difflib.get_close_matches(key.lower(), known, n=1, cutoff=_ALIKE)
        key = prefix + shown(key)
        if notes and alike:
            raise InputError(
                f"{source}: unknown key {key}, expected {prefix}{alike[0]}; rename it or, if it is "
                f"a note of your own, choose a name that differs more"
            )
        if not notes:
            meant = f" (did you mean {prefix}{alike[0]}?)" if alike else ""
            raise InputError(
                f"{source}: unknown key {key}, expected one of {', '.join(known)}{meant}; rename "
                f"or remove it"
            )


def _value(value: Any, hint: Any, source: Path | str, key: str, notes: bool = False) -> Any:
    bare = _bare(hint)
    if dataclasses.is_dataclass(bare):
        return validated(value, bare, source, key, notes=notes)  # type: ignore[arg-type]
    if get_origin(bare) is Mapping and isinstance(value, Mapping):
        inner = get_args(bare)[1]
        return {
            one: _value(item, inner, source, f"{key}.{one}", notes) for one, item in value.items()
        }
    try:
        if not _finite(value) and not _extra(hint).get("infinite", False):
            raise _wrong(value, source, key, _WORDS[float], _FIX)
        return msgspec.convert(value, hint)
    except (msgspec.ValidationError, UnicodeEncodeError):  # the latter: no text, but bytes
        if bare is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)  # as it is read
        raise _wrong(value, source, key, *_words(hint)) from None


def _wrong(value: Any, source: Path | str, key: str, expected: str, fix: str) -> InputError:
    return InputError(f"{source}: key {key} is {_shown(value)}, expected {expected}; {fix}")


def _finite(value: Any) -> bool:
    if isinstance(value, list | tuple):
        return all(map(_finite, value))
    return not isinstance(value, float) or math.isfinite(value)


def _words(hint: Any) -> tuple[str, str]:
    """What a field holds, and how to fix one that does not."""
    described = [meta.description for meta in _metas(hint) if meta.description]
    bare = _bare(hint)
    kinds = get_args(bare) if isinstance(bare, UnionType) else (bare,)
    plain = [_WORDS[one] for one in kinds if one in _WORDS]
    return (described or plain or [str(bare)])[0], str(_extra(hint).get("fix", _FIX))


def _metas(hint: Any) -> list[msgspec.Meta]:
    found = [meta for meta in getattr(hint, "__metadata__", ()) if isinstance(meta, msgspec.Meta)]
    return found + [meta for inner in get_args(hint) for meta in _metas(inner)]


def _extra(hint: Any) -> dict[str, Any]:
    return {key: value for meta in _metas(hint) for key, value in (meta.extra or {}).items()}


def _is_apart(hint: Any) -> bool:
    return "apart" in _extra(hint)


def _bare(hint: Any) -> Any:
    """The type without its annotations, and without ``| None``."""
    if get_origin(hint) is Annotated:
        return _bare(get_args(hint)[0])
    others = [one for one in get_args(hint) if one is not NoneType]
    if isinstance(hint, UnionType) and len(others) == 1:
        return _bare(others[0])
    return hint


def _shown(value: object) -> str:
    return shown(repr(value))
