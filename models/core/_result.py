"""What the verbs return: frozen values that show themselves, are saved and are read back."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, ClassVar, Self, SupportsIndex, TypeVar, overload

from servosight.models.base import InputError, json_text, plain, read_json, write_text
from servosight.models.core._frozen import Frozen
from servosight.models.core._recording import Recording
from servosight.models.core.display import (
    Rows,
    frame,
    html_table,
    parameter_rows,
    rounded,
    text_table,
)
from servosight.models.schema import typed

SCHEMA = 1
LONGEST_WORDS = 40
"""Longer texts are sentences, which no ``__repr__`` has."""
T = TypeVar("T")


class Table(tuple[T, ...]):
    """Rows of one kind, each a frozen dataclass: a tuple that shows itself and becomes a frame.

    >>> Table([]).to_list()
    []
    """

    __slots__ = ()

    def to_list(self) -> list[dict[str, Any]]:
        """The rows as JSON has them."""
        return [plain(row) for row in self]

    def to_frame(self) -> Any:
        """A pandas data frame or, without pandas, a Polars one; InputError without either."""
        return frame(self.to_list())

    @overload
    def __getitem__(self, place: SupportsIndex) -> T: ...
    @overload
    def __getitem__(self, place: slice) -> Table[T]: ...
    def __getitem__(self, place: SupportsIndex | slice) -> T | Table[T]:
        """A row, or a shorter table."""
        found = super().__getitem__(place)
        return Table(found) if isinstance(place, slice) else found  # type: ignore[arg-type, return-value]

    def __str__(self) -> str:
        """Aligned columns."""
        return text_table(self.to_list()) if self else "no rows"

    def __repr__(self) -> str:
        """How many rows of what."""
        return f"<Table of {len(self)} x {type(self[0]).__name__}>" if self else "<Table, empty>"

    def _repr_html_(self) -> str:
        return html_table(self.to_list())


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Result(Frozen):
    """Base of what a verb returns.

    A subclass is ``@dataclass(frozen=True, kw_only=True, repr=False, eq=False)`` and has a
    ``TYPE`` of its own. Its fields are plain values: numbers, text, arrays, ``Table`` and mappings
    of them, and frozen dataclasses with such fields; their names are the keys of its JSON. What it
    computes from them is a property. JSON has neither NaN nor Infinity: a number that may be
    unknown is ``float | None``.
    """

    TYPE: ClassVar[str]

    def to_dict(self) -> dict[str, Any]:
        """The JSON of the command line, as plain values."""
        own = {f.name: plain(getattr(self, f.name)) for f in fields(self)}
        return {"schema": SCHEMA, "type": self.TYPE, **own}

    @classmethod
    def from_dict(cls, table: Mapping[str, Any]) -> Self:
        """The inverse of ``to_dict``; InputError names the key that is wrong."""
        if table.get("type", cls.TYPE) != cls.TYPE:
            raise InputError(
                f"key type is {table['type']!r}, expected {cls.TYPE!r}; load() reads any"
            )
        if table.get("schema", SCHEMA) != SCHEMA:
            raise InputError(
                f"key schema is {table['schema']!r}, expected {SCHEMA}; update servosight or save "
                f"the result again"
            )
        return typed(table, cls)

    def save(self, path: Path | str) -> None:
        """Write JSON, completely or not at all; ``servosight.load`` reads it back."""
        write_text(Path(path), json_text(self.to_dict()))

    @classmethod
    def load(cls, path: Path | str) -> Self:
        """Read what ``save`` wrote; InputError names the file and the key that is wrong."""
        try:
            return cls.from_dict(read_json(path))
        except InputError as error:
            words = str(error)
            raise InputError(words if str(path) in words else f"{path}: {words}") from None

    def remember(
        self, recordings: Sequence[Recording], catalogue: Mapping[str, Any] | None = None
    ) -> Self:
        """This value, with its recordings and effects at hand for plots and reports; not saved."""
        object.__setattr__(self, "_recordings", tuple(recordings))
        object.__setattr__(self, "_catalogue", catalogue)
        return self

    @property
    def known_effects(self) -> Mapping[str, Any] | None:
        """The catalogue that it was made with, None where it was read back."""
        return getattr(self, "_catalogue", None)

    def sources(self) -> tuple[Recording | Path, ...]:
        """Its recordings: as they were given or, where it was read back, where they were.

        Raises InputError where it does not know.
        """
        found = getattr(self, "_recordings", None) or tuple(dict.fromkeys(self._paths()))
        known = tuple(one for one in found if one is not None)
        if not known or len(known) != len(found):
            raise InputError(
                f"{type(self).__name__.lower()}: does not say where its recordings are, expected "
                f"them as well; name them in the order in which they were given"
            )
        return known

    @property
    def moved(self) -> tuple[Path, ...]:
        """Where its recordings were, and are no more."""
        return tuple(one for one in self._paths() if one is not None and not one.exists())

    def _paths(self) -> Sequence[Path | None]:
        """Where its recordings were, None for what was in memory alone."""
        return ()

    def to_frame(self) -> Any:
        """The first of its tables as a data frame (pandas, else Polars)."""
        return frame(next(iter(self._tables().values()), [self.to_dict()]))

    def _summary(self) -> str:
        """One line: the fields that are single numbers or words, sentences apart."""
        single = {f.name: getattr(self, f.name) for f in fields(self)}
        return ", ".join(
            f"{name} {rounded(value) if isinstance(value, float) else value}"
            for name, value in single.items()
            if isinstance(value, str | int | float) and not _is_sentence(value)
        )

    def _sentences(self) -> list[str]:
        """The fields that are sentences."""
        return [text for f in fields(self) if _is_sentence(text := getattr(self, f.name))]

    def _tables(self) -> Mapping[str, Rows]:
        """Heading and rows of each table to show, in order."""
        found: dict[str, Rows] = {}
        for f in fields(self):
            value = getattr(self, f.name)
            if isinstance(value, Table):
                if value:
                    found[f.name] = value.to_list()
            elif f.name == "parameters":
                found[f.name] = parameter_rows(value)
        return found

    def __eq__(self, other: object) -> bool:
        """Equal where the saved values are."""
        return type(other) is type(self) and other.to_dict() == self.to_dict()

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        """The kind and one line."""
        return f"<{type(self).__name__}: {self._summary()}>"

    def __str__(self) -> str:
        """The line, the sentences and the tables as text."""
        blocks = (f"{name}\n{text_table(rows)}" for name, rows in self._tables().items())
        line = f"{type(self).__name__}: {self._summary()}"
        return "\n\n".join([line, *self._sentences(), *blocks])

    def _repr_html_(self) -> str:
        tables = "".join(html_table(rows, name) for name, rows in self._tables().items())
        words = "".join(f"<p>{_lines(text)}</p>" for text in self._sentences())
        line = html.escape(self._summary())
        return f"<p><b>{type(self).__name__}</b>: {line}</p>{words}{tables}"


def _lines(text: str) -> str:
    return html.escape(text).replace("\n", "<br>")


def _is_sentence(value: object) -> bool:
    return isinstance(value, str) and len(value) > LONGEST_WORDS
