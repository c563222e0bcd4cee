"""Tables of numbers in text files: fast where they are right, exact about what is wrong."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from servosight.models.core import LARGEST_TABLE, Array, InputError, read_text

LONGEST_LINE = 100_000
_UNQUOTED = "\x1f"  # ASCII's own unit separator stands in for the delimiter of a quoted table


@dataclass(frozen=True)
class Sheet:
    """A delimited text file with one header row; its cells are read on demand.

    ``rows`` are the lines that are not blank, ``numbers`` their 1-based lines in the file.
    """

    path: Path
    header: tuple[str, ...]
    rows: tuple[str, ...]
    numbers: tuple[int, ...]
    delimiter: str

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

    def _number(self, line: int, name: str, cell: str) -> float:
        try:
            if "_" in cell:  # Python reads 1_000, no other program does
                raise ValueError
            return float(cell)
        except ValueError:
            shown = repr(cell.strip()[:40]) if cell.strip() else "empty"
            raise InputError(
                f"{self.path}, row {line}: column {name} is {shown}, expected a number; correct "
                "the "
                f"cell or delete the row"
            ) from None


def read_sheet(path: Path) -> Sheet:
    """Read a table separated by commas, semicolons or tabs; BOM and any line ends are accepted.

    Beside semicolons and tabs a comma in a number is a decimal comma. InputError for a file that
    is missing, empty, too large, not UTF-8, without header, or with a row of another width.
    """
    text = read_text(path, "a CSV file", LARGEST_TABLE)
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    numbers = [number for number, line in enumerate(lines, 1) if line.strip()]
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
    delimiter = _delimiter(lines[numbers[0] - 1])
    rows = [lines[number - 1] for number in numbers]
    if '"' in text:
        rows = [
            _unquoted(path, number, row, delimiter)
            for number, row in zip(numbers, rows, strict=True)
        ]
        delimiter, was = _UNQUOTED, delimiter
    else:
        was = delimiter
    header = tuple(name.strip() for name in rows[0].split(delimiter))
    if was != ",":
        rows = [row.replace(",", ".") for row in rows]
    _check_header(path, numbers[0], header)
    _check_names(path, numbers[0], header, rows[1:], delimiter)
    for number, row in zip(numbers, rows, strict=True):
        if row.count(delimiter) != len(header) - 1:
            raise InputError(
                f"{path}, row {number}: the row has {row.count(delimiter) + 1} fields, expected "
                f"{len(header)} as in the header; correct the row or delete it"
            )
    return Sheet(path, header, tuple(rows[1:]), tuple(numbers[1:]), delimiter)


def table_text(header: Sequence[str], columns: Sequence[Array]) -> str:
    """CSV text of columns (rows,), each number with the digits that read back to itself."""
    rows = zip(*(column.tolist() for column in columns), strict=True)
    body = "".join(",".join(map(repr, row)) + "\n" for row in rows)
    return ",".join(header) + "\n" + body


def _delimiter(header: str) -> str:
    """The separator that the header uses; a comma unless it has only others."""
    return next((mark for mark in (",", ";", "\t") if mark in header), ",")


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
    if all(_is_number(name) for name in header):
        raise InputError(
            f"{path}, row {number}: the first row holds numbers, expected a header; write the "
            f"names of the {len(header)} columns above the numbers, such as "
            f"time_s,command_deg,angle_deg"
        )
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
    if all(not row.rpartition(delimiter)[2].strip() for row in rows):
        raise InputError(
            f"{path}, row {number}: every row but the header ends with a separator, expected a "
            f"name for each field; end the header with one, too"
        )
    raise InputError(
        f"{path}, row {number}: the header has {len(header)} names and every row {len(header) + 1} "
        f"fields, expected a name for each; where the rows begin with an index, write its name in "
        f"front of the header, as in index,{','.join(header[:2])}"
    )


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
