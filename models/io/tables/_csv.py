"""Tables of numbers in text files: fast where they are right, exact about what is wrong."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from servosight.models.core import LARGEST_TABLE, Array, InputError, read_text
from servosight.models.io.tables._dates import is_date

LONGEST_LINE = 100_000
COMMENT = "#"
_MARKS = (",", ";", "\t")
_UNQUOTED = "\x1f"  # ASCII's own unit separator stands in for the delimiter of a quoted table


@dataclass(frozen=True)
class Sheet:
    """A delimited text file with one header row; its cells are read on demand.

    ``rows`` are the lines that are neither blank nor comments, ``numbers`` their 1-based lines in
    the file, ``notes`` what the user should know.
    """

    path: Path
    header: tuple[str, ...]
    rows: tuple[str, ...]
    numbers: tuple[int, ...]
    delimiter: str
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
                f"{self.path}, row {line}: column {name} is {shown}, expected a number; correct "
                "the "
                f"cell or delete the row"
            ) from None


def read_sheet(path: Path) -> Sheet:
    """Read a table separated by commas, semicolons, tabs or spaces; any BOM and line ends will do.

    Beside other separators a comma in a number is a decimal comma. Lines that begin with ``#`` are
    skipped; the last before the numbers is the header where it names each column. InputError for a
    file that is missing, empty, too large, not UTF-8, without header, or with a row of another
    width.
    """
    text = read_text(path, "a CSV file", LARGEST_TABLE)
    lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
    numbers, notes = _content(path, lines)
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
    delimiter = _delimiter(rows[0], rows[1] if len(rows) > 1 else "")
    if delimiter == " ":
        rows = [" ".join(row.split()) for row in rows]
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
    return Sheet(path, header, tuple(rows[1:]), tuple(numbers[1:]), delimiter, notes)


def table_text(header: Sequence[str], columns: Sequence[Array]) -> str:
    """CSV text of columns (rows,), each number with the digits that read back to itself."""
    rows = zip(*(column.tolist() for column in columns), strict=True)
    body = "".join(",".join(map(repr, row)) + "\n" for row in rows)
    return ",".join(header) + "\n" + body


def _content(path: Path, lines: Sequence[str]) -> tuple[list[int], tuple[str, ...]]:
    """Where the header and the rows are, from 1, and a note where comments are skipped."""
    filled = [number for number, line in enumerate(lines, 1) if line.strip()]
    comments = [number for number in filled if lines[number - 1].lstrip().startswith(COMMENT)]
    if not comments:
        return filled, ()
    skipped = set(comments)
    numbers = [number for number in filled if number not in skipped]
    above = [number for number in comments if numbers and number < numbers[0]]
    if above and _names_columns(lines[above[-1] - 1], lines[numbers[0] - 1]):
        skipped.remove(above[-1])
        numbers.insert(0, above[-1])
    if not skipped:
        return numbers, ()
    count = f"{len(skipped):,} line{'s' * (len(skipped) > 1)}"
    begin, are = ("begin", "are") if len(skipped) > 1 else ("begins", "is")
    first = min(skipped)
    note = f"{path}: {count} that {begin} with {COMMENT} {are} skipped, the first is row {first}"
    return numbers, (note,)


def _names_columns(comment: str, row: str) -> bool:
    """True where a comment has a name for each number of the first row, as numpy writes it."""
    header = comment.lstrip().removeprefix(COMMENT).strip()
    mark = _delimiter(header, row)
    cells, names = _split(row, mark), _split(header, mark)
    return len(cells) == len(names) > 1 and all(_is_number(one) or is_date(one) for one in cells)


def _split(row: str, mark: str) -> list[str]:
    return row.split() if mark == " " else row.split(mark)


def _delimiter(header: str, row: str) -> str:
    """The separator that cuts header and first row into as many fields; else what the header has.

    A comma where there is none.
    """
    for mark in (*_MARKS, " "):
        if len(_split(header, mark)) == len(_split(row, mark)) > 1:
            return mark
    return next((mark for mark in _MARKS if mark in header), ",")


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
