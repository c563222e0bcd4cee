"""Tables of numbers in text files: fast where they are right, exact about what is wrong."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from servosight.models.core import LARGEST_TABLE, Array, InputError
from servosight.models.io.tables._layout import (
    COMMENT,
    QUOTE,
    delimiter_of,
    is_number,
    layout_of,
    with_units,
)
from servosight.models.io.tables._text import log_text

LONGEST_LINE = 100_000
_GROUPED = re.compile(r"[+-]?(?:\d{1,3}(?:,\d{3})+\.\d*|\d{1,3}(?:\.\d{3})+,\d*)")
"""A number with separators of thousands and a decimal mark."""
_WITH_COMMA = re.compile(r"[+-]?\d*,\d+(?:[eE][+-]?\d+)?")
_OF_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")
"""A number that may be with a separator of thousands, or with a decimal comma."""
_GROUPS = re.compile(r"\d[,'\u2019\u00a0\u202f ]\d{3}\b")
_DATE = re.compile(r"\d\s*[/:.-]\s*\d+\s*[/:.-]\s*\d")
_MISSING = ("", "na", "n/a", "#n/a", "null", "none", "-", "--")
"""What stands in a cell without a number, in lower case; Python itself reads nan."""
_UNQUOTED = "\x1f"  # ASCII's own unit separator stands in for the delimiter of a quoted table


@dataclass(frozen=True)
class Sheet:
    """A delimited text file with one header row; its cells are read on demand.

    ``rows`` are the lines that are neither blank nor comments, ``numbers`` their 1-based lines in
    the file, ``place`` is that of the header in messages, ``notes`` what the user should know.
    """

    path: Path
    header: tuple[str, ...]
    rows: tuple[str, ...]
    numbers: tuple[int, ...]
    delimiter: str
    place: str
    notes: tuple[str, ...] = ()

    def columns(self, names: Sequence[str]) -> Array:
        """The numbers of ``names``, shape (rows, names); text and empty cells are refused."""
        if not self.rows:
            return np.empty((0, len(names)))
        picks = [self.header.index(name) for name in names]
        try:
            return np.loadtxt(
                self.rows, delimiter=self.delimiter, usecols=picks, ndmin=2, comments=None
            )
        except ValueError:
            cells = [[row.split(self.delimiter)[pick] for pick in picks] for row in self.rows]
        return np.array(
            [
                [self._number(line, name, cell) for name, cell in zip(names, row, strict=True)]
                for line, row in zip(self.numbers, cells, strict=True)
            ]
        )

    def cells(self, name: str) -> list[str]:
        """The text of a column, (rows,)."""
        place = self.header.index(name)
        return [row.split(self.delimiter)[place] for row in self.rows]

    def _number(self, line: int, name: str, cell: str) -> float:
        try:
            if "_" in cell:  # Python reads 1_000, no other program does
                raise ValueError
            return float(cell)
        except ValueError:
            shown = repr(cell.strip()[:40]) if cell.strip() else "empty"
            raise InputError(
                f"{self.path}, row {line}: column {name} is {shown}, expected {_wanted(cell)}; "
                f"correct the cell or delete the row"
            ) from None


def with_gaps(sheet: Sheet, name: str) -> Sheet:
    """One column of a sheet, with NaN where a cell is empty or says that it has no number."""
    cells = (("nan" if cell.strip().lower() in _MISSING else cell) for cell in sheet.cells(name))
    return replace(sheet, header=(name,), rows=tuple(cells))


def _wanted(cell: str) -> str:
    if _DATE.search(cell):
        return "a number, or a date such as 2026-03-01T12:00:00.250"
    if _GROUPS.search(cell):
        return "a number without separators of thousands"
    return "a number"


def read_sheet(path: Path) -> Sheet:
    """Read a table separated by commas, semicolons, tabs or spaces; any BOM and line ends will do.

    Beside other separators a comma in a number is a decimal comma, and in quotes where no number
    has a point and one cannot be read otherwise, as "0,25" and not "1,250". What stands above the
    header is skipped, a row of units below it is joined with it, and columns without a header are
    called by their numbers, from 1. InputError for a file that is missing, empty, too large or no
    text, or with a row of another width.
    """
    text = log_text(path, "a CSV file", LARGEST_TABLE)
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    layout = layout_of(path, lines)
    numbers, notes = layout.numbers, layout.notes
    if not numbers:
        raise InputError(
            f"{path}: the file is empty, expected a header row and rows of numbers; write the "
            f"recording again"
        )
    for number in numbers:
        if len(lines[number - 1]) > LONGEST_LINE:
            raise InputError(
                f"{path}, row {number}: the row has {len(lines[number - 1])} characters, expected "
                f"at most {LONGEST_LINE}; check that the file is a table with line ends"
            )
    rows = [lines[number - 1] for number in numbers]
    if rows[0].lstrip().startswith(COMMENT):
        rows[0] = rows[0].lstrip().removeprefix(COMMENT).strip()
    delimiter = delimiter_of(rows[0], rows[1] if len(rows) > 1 else "")
    decimal_comma = delimiter != ","
    if delimiter == " ":
        rows = [" ".join(row.split()) for row in rows]
    rows = _without_last_separator(rows, delimiter)
    quoted = QUOTE in text
    if quoted:
        rows = [
            _unquoted(path, number, row, delimiter)
            for number, row in zip(numbers, rows, strict=True)
        ]
        delimiter = _UNQUOTED
        decimal_comma = decimal_comma or _has_decimal_commas(rows[1:])
    header = tuple(name.strip() for name in rows[0].split(delimiter))
    if quoted or decimal_comma:
        rows = [_plain_row(row, delimiter, decimal_comma) for row in rows]
    first = 1
    if all(is_number(name) for name in rows[0].split(delimiter)):
        header, first = tuple(str(place) for place in range(1, len(header) + 1)), 0
        notes = (*notes, f"{path}: has no header, so its columns are called 1 to {len(header)}")
    _check_header(path, numbers[0], header)
    _check_names(path, numbers[0], header, rows[1:], delimiter)
    for number, row in zip(numbers, rows, strict=True):
        if row.count(delimiter) != len(header) - 1:
            raise InputError(
                f"{path}, row {number}: the row has {_fields(row, delimiter)}, expected "
                f"{len(header)} as in the header; correct the row or delete it"
            )
    units = with_units(header, rows[1].split(delimiter)) if first and len(rows) > 1 else None
    if units is not None:
        header, first = units, 2
    place = f"{path}, row {numbers[0]}" if first else f"{path}, without a header"
    return Sheet(path, header, tuple(rows[first:]), numbers[first:], delimiter, place, notes)


def table_text(header: Sequence[str], columns: Sequence[Array]) -> str:
    """CSV text of columns (rows,), each number with the digits that read back to itself."""
    rows = zip(*(column.tolist() for column in columns), strict=True)
    body = "".join(",".join(map(repr, row)) + "\n" for row in rows)
    return ",".join(header) + "\n" + body


def _fields(row: str, delimiter: str) -> str:
    count = row.count(delimiter) + 1
    return f"{count} field{'s' * (count > 1)}"


def _without_last_separator(rows: Sequence[str], delimiter: str) -> list[str]:
    """Rows without a separator at the end where either only they or only the header have one."""
    header, *body = (row.rstrip(" ") for row in rows)
    more = {row.count(delimiter) - header.count(delimiter) for row in body}
    if more == {1} and all(row.endswith(delimiter) for row in body):
        return [header, *(row[: -len(delimiter)] for row in body)]
    if more == {-1} and header.endswith(delimiter):
        return [header[: -len(delimiter)], *body]
    return list(rows)


def _has_decimal_commas(rows: Sequence[str]) -> bool:
    """True where quoted numbers have decimal commas and none has a decimal point."""
    cells = [cell.strip() for row in rows for cell in row.split(_UNQUOTED)]
    return any(
        _WITH_COMMA.fullmatch(cell) and not _OF_THOUSANDS.fullmatch(cell) for cell in cells
    ) and not any("." in cell and is_number(cell) for cell in cells)


def _plain_row(row: str, delimiter: str, decimal_comma: bool) -> str:
    """A row in which numbers have a decimal point alone.

    Of a point and a comma in one number the last is the decimal mark.
    """
    if "," not in row:
        return row
    if "." not in row:
        return row.replace(",", ".") if decimal_comma else row
    return delimiter.join(_plain_cell(cell, decimal_comma) for cell in row.split(delimiter))


def _plain_cell(cell: str, decimal_comma: bool) -> str:
    if _GROUPED.fullmatch(cell.strip()):
        mark = max(".,", key=cell.rfind)
        return cell.replace("," if mark == "." else ".", "").replace(mark, ".")
    return cell.replace(",", ".") if decimal_comma else cell


def _unquoted(path: Path, number: int, row: str, delimiter: str) -> str:
    try:
        cells = next(csv.reader([row], delimiter=delimiter, strict=True))
    except csv.Error as error:
        raise InputError(
            f"{path}, row {number}: the quotes do not match ({error}), expected a row of plain "
            f"numbers; remove the quotes"
        ) from None
    return _UNQUOTED.join(cell.replace(_UNQUOTED, " ") for cell in cells)


def _check_header(path: Path, number: int, header: tuple[str, ...]) -> None:
    for place, name in enumerate(header):
        if name and name in header[:place]:
            raise InputError(
                f"{path}, row {number}: column {name} appears twice, expected each name once; "
                f"rename or remove one"
            )


def _check_names(
    path: Path, number: int, header: tuple[str, ...], rows: Sequence[str], delimiter: str
) -> None:
    """Refuse a header with one name less than all rows have fields."""
    if not rows or any(row.count(delimiter) != len(header) for row in rows):
        return
    raise InputError(
        f"{path}, row {number}: the header has {len(header)} names and every row {len(header) + 1} "
        f"fields, expected a name for each; where the rows begin with an index, write its name in "
        f"front of the header, as in index,{','.join(header[:2])}"
    )
