"""What leaves the program: JSON, human text and progress, each on its own way."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from servosight.models.atomic import check_target, write_text

if TYPE_CHECKING:
    from rich.console import Console

STANDARD_OUTPUT = "-"


def plain(value: Any) -> Any:
    """``value`` as JSON knows it: numpy's numbers and arrays unpacked, NaN and infinity as null."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Path):
        return str(value)
    return value


def json_text(value: Any) -> str:
    """JSON in the order of its keys, two spaces deep; never NaN or Infinity."""
    return json.dumps(plain(value), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def check_outputs(args: argparse.Namespace) -> None:
    """Refuse files that could not be written, before the work begins."""
    for name in ("output", "report", "json"):
        place = getattr(args, name, None)
        if place is not None and place != STANDARD_OUTPUT:
            check_target(Path(place))


def write_json(place: str | None, value: Any) -> None:
    """Write JSON to a file, whole or not at all, or to standard output where ``place`` is ``-``."""
    if place is None:
        return
    text = json_text(value)
    if place == STANDARD_OUTPUT:
        sys.stdout.write(text)
        sys.stdout.flush()
    else:
        write_text(Path(place), text)


def console(args: argparse.Namespace) -> Console:
    """Where human text goes: standard output, unless JSON has that for itself."""
    from rich.console import Console

    class Plain(Console):
        def on_broken_pipe(self) -> None:
            raise BrokenPipeError

    on_error = getattr(args, "json", None) == STANDARD_OUTPUT
    return Plain(stderr=on_error, markup=False, highlight=False, soft_wrap=True)


@contextmanager
def progress(title: str) -> Iterator[Callable[[Any], None]]:
    """A line on standard error that says how far a long piece of work is; silent off a terminal.

    Gives a function that takes what is done so far: a count or a word.
    """
    if not sys.stderr.isatty():
        yield lambda _done: None
        return
    from rich.console import Console

    with Console(stderr=True, markup=False).status(title) as status:
        yield lambda done: status.update(f"{title}: {done}")
