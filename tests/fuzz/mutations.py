"""Seeded damage to files: to bytes, to lines, to numbers, to TOML, and to arguments."""

from __future__ import annotations

import random
import re
from collections.abc import Callable

NUMBERS = (
    *("0", "-0.0", "1", "-1", "0.5", "1e-320", "1e-9", "1e9", "1e17", "1e300", "1e308", "-1e308"),
    *(
        "1e400",
        "nan",
        "inf",
        "-inf",
        "",
        "x",
        "1,5",
        "1_000",
        "0x10",
        "9" * 400,
        "true",
        "[]",
        "''",
    ),
    *("{}", '"a"', "2026-01-01", "-5", "1e5", "3", "1000000", "[1, 2]", "[[]]"),
)
_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?(?:e-?\d+)?")
_ODD = (
    *(b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b'"', b"'''", b"[", b"]" * 9, b"=", b",", b";"),
    *(b"\r", b"\n\n", b"\t", b"#", b"-", b"/", b"{" * 200, b"[" * 2000, b"a." * 3000),
    "ü²½".encode(),
)

Mutation = Callable[[random.Random, bytes], bytes]


def flip_bytes(rng: random.Random, data: bytes) -> bytes:
    """Change up to eight bytes."""
    changed = bytearray(data)
    for _ in range(rng.randint(1, 8)):
        if changed:
            changed[rng.randrange(len(changed))] = rng.randrange(256)
    return bytes(changed)


def cut(rng: random.Random, data: bytes) -> bytes:
    """Leave the end off, or a stretch out."""
    first = rng.randrange(len(data) + 1)
    last = len(data) if rng.random() < 0.5 else rng.randrange(first, len(data) + 1)
    return data[:first] + data[last:]


def repeat(rng: random.Random, data: bytes) -> bytes:
    """Write a stretch several times."""
    first = rng.randrange(len(data) + 1)
    last = min(len(data), first + rng.randint(1, 200))
    return data[:last] + data[first:last] * rng.choice((1, 2, 50, 3000)) + data[last:]


def insert(rng: random.Random, data: bytes) -> bytes:
    """Put odd bytes somewhere."""
    odd = rng.choice(_ODD)
    place = rng.randrange(len(data) + 1)
    return data[:place] + odd + data[place:]


def change_number(rng: random.Random, data: bytes) -> bytes:
    """Write another number, or what is none, in the place of one."""
    found = list(_NUMBER.finditer(data))
    if not found:
        return flip_bytes(rng, data)
    match = rng.choice(found)
    return data[: match.start()] + rng.choice(NUMBERS).encode() + data[match.end() :]


def nudge_numbers(rng: random.Random, data: bytes) -> bytes:
    """Change up to five numbers a little, or a lot."""
    for _ in range(rng.randint(1, 5)):
        found = list(_NUMBER.finditer(data))
        if not found:
            break
        match = rng.choice(found)
        factor = rng.choice((0.5, 0.9, 1.1, 2.0, -1.0, 10.0))
        number = f"{float(match[0]) * factor:.6g}".encode()
        data = data[: match.start()] + number + data[match.end() :]
    return data


def scale_column(rng: random.Random, data: bytes) -> bytes:
    """Multiply one column of a table."""
    factor = rng.choice((0.0, -1.0, 1e-12, 1e-6, 1e3, 1e6, 1e9, 1e12, 1e300))
    lines = data.decode("utf-8", "replace").splitlines()
    column = rng.randrange(max(1, lines[0].count(",") + 1)) if lines else 0
    for index, line in enumerate(lines[1:], 1):
        cells = line.split(",")
        try:
            cells[column] = repr(float(cells[column]) * factor)
        except (ValueError, IndexError):
            continue
        lines[index] = ",".join(cells)
    return "\n".join(lines).encode() + b"\n"


def constant_stretch(rng: random.Random, data: bytes) -> bytes:
    """Hold one column of a table over a stretch, or all of it."""
    lines = data.decode("utf-8", "replace").splitlines()
    if len(lines) < 3:
        return data
    column = rng.randrange(lines[0].count(",") + 1)
    first, last = sorted(rng.sample(range(1, len(lines) + 1), 2))
    if rng.random() < 0.3:
        first, last = 1, len(lines)
    value = (lines[first].split(",") + [""] * 9)[column]
    for index in range(first, last):
        cells = lines[index].split(",")
        if column < len(cells):
            cells[column] = value
        lines[index] = ",".join(cells)
    return "\n".join(lines).encode() + b"\n"


def shuffle_lines(rng: random.Random, data: bytes) -> bytes:
    """Swap, drop or double lines."""
    lines = data.splitlines(keepends=True)
    if not lines:
        return data
    for _ in range(rng.randint(1, 4)):
        first, second = rng.randrange(len(lines)), rng.randrange(len(lines))
        kind = rng.randrange(3)
        if kind == 0:
            lines[first], lines[second] = lines[second], lines[first]
        elif kind == 1 and len(lines) > 1:
            del lines[first]
        else:
            lines.insert(first, lines[second])
    return b"".join(lines)


def rename(rng: random.Random, data: bytes) -> bytes:
    """Write another word in the place of one."""
    words = list(re.finditer(rb"[a-zA-Z_]{2,}", data))
    if not words:
        return insert(rng, data)
    first, second = rng.choice(words), rng.choice(words)
    other = rng.choice((second[0], b"", b"x", b"format", b"\xc3\xbc", first[0] * 400))
    return data[: first.start()] + other + data[first.end() :]


def long_integer(rng: random.Random, data: bytes) -> bytes:
    """An integer beyond what Python converts, or deep nesting, behind an equals sign."""
    places = [match.end() for match in re.finditer(rb"=", data)]
    if not places:
        return insert(rng, data)
    place = rng.choice(places)
    end = data.find(b"\n", place)
    end = len(data) if end < 0 else end
    value = rng.choice((b"9" * 5000, b"[" * 1500 + b"]" * 1500, b'"""' + b"x" * 9, b"{a." * 900))
    return data[:place] + b" " + value + data[end:]


BYTES: tuple[Mutation, ...] = (flip_bytes, cut, repeat, insert)
TEXT: tuple[Mutation, ...] = (
    *BYTES,
    *(change_number, change_number, nudge_numbers, nudge_numbers, shuffle_lines, rename),
)
TABLE: tuple[Mutation, ...] = (*TEXT, scale_column, constant_stretch, constant_stretch)
SETTINGS: tuple[Mutation, ...] = (*TEXT, change_number, change_number, long_integer)


def mutated(rng: random.Random, data: bytes, kinds: tuple[Mutation, ...]) -> bytes:
    """One to three mutations, one after the other; at most 1 MB."""
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        data = rng.choice(kinds)(rng, data)
    return data[: 1 << 20]
