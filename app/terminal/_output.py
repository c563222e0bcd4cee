"""What leaves the program: JSON, files and human text, each on its own way."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

from servosight.app.terminal._progress import quiet, set_amount
from servosight.models.base import (
    InputError,
    Kind,
    json_text,
    kind_of,
    remove_stale_temporaries,
    write_text,
)

if TYPE_CHECKING:
    from rich.console import Console

STANDARD_OUTPUT = Path("-")
WRITTEN = {
    "report": Kind.HTML,
    "json": Kind.JSON,
    "next_command": Kind.TABLE,
    "draft": Kind.PLUGIN,
    "overlay": Kind.VIDEO,
    "sheet": Kind.PNG,
    "print": Kind.PNG,
}
"""Arguments that name a file to write, beside ``-o``."""
PIPED_WIDTH = 120


def check_outputs(args: argparse.Namespace, output: Kind = Kind.MODEL) -> None:
    """Refuse, before the work begins, files that could not be written or must not be replaced.

    ``output`` is what the command writes to its ``-o``.
    """
    named: set[Path] = set()
    for name, kind in {"output": output, **WRITTEN}.items():
        place = getattr(args, name, None)
        if place is None or place == STANDARD_OUTPUT:
            continue
        check_target(Path(place), kind, force=args.force)
        target = Path(os.path.realpath(place))
        if target in named and (target.is_file() or not target.exists()):
            raise InputError(
                f"{place}: is named for two results; expected a file for each, change one name"
            )
        named.add(target)


def check_target(path: Path, kind: Kind, *, force: bool = False) -> None:
    """Refuse a place that cannot be written, or a file that is no earlier result of this kind."""
    target = Path(os.path.realpath(path))
    exists, is_file = target.exists(), target.is_file()
    if target.is_dir():
        raise InputError(
            f"{path}: is a folder, expected the name of a file to write; add a name to it"
        )
    if not target.parent.is_dir():
        raise InputError(
            f"{path}: the folder {path.parent} does not exist, expected an existing one; make it "
            f"or choose another"
        )
    needed = ([target] if exists else []) + ([target.parent] if is_file or not exists else [])
    if not all(os.access(place, os.W_OK) for place in needed):
        raise InputError(
            f"{path}: may not be written, expected a folder of your own; choose another or correct "
            f"its permissions"
        )
    if is_file and not force and kind_of(target) is not kind:
        raise InputError(refusal(path, kind))
    remove_stale_temporaries(target.parent)


def refusal(path: Path, kind: Kind) -> str:
    """The sentence for a file that is not replaced."""
    unsigned = {
        Kind.TABLE: "a CSV file carries no mark of who wrote it",
        Kind.PLUGIN: "a drafted plugin is there to be edited",
    }
    why = unsigned.get(kind, "carries no mark that servosight wrote it")
    return (
        f"{path}: the file exists and {why}, expected a new name; choose another or replace the "
        f"file with --force"
    )


def write_json(place: Path | None, value: Any) -> None:
    """Write JSON to a file, completely or not at all; to standard output for ``-``."""
    if place is None:
        return
    text = json_text(value)
    if place != STANDARD_OUTPUT:
        write_text(place, text)
        return
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except BrokenPipeError:
        ignore_closed_pipe(sys.stdout)


def ignore_closed_pipe(stream: TextIO) -> None:
    """Go on without a reader, such as `head`, that has seen enough: what goes into files is still
    to be written."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


def console(args: argparse.Namespace) -> Console:
    """Where human text goes: standard output, unless JSON has that for itself."""
    from rich.console import Console

    class Plain(Console):
        def on_broken_pipe(self) -> None:
            self.quiet = True
            ignore_closed_pipe(stream)

    on_error = getattr(args, "json", None) == STANDARD_OUTPUT
    stream = sys.stderr if on_error else sys.stdout
    width = None if stream.isatty() else PIPED_WIDTH
    return Plain(
        stderr=on_error,
        width=width,
        markup=False,
        highlight=False,
        soft_wrap=True,
        quiet=quiet(),
    )


def show_notes(args: argparse.Namespace) -> None:
    """Print what the library reports while it works, such as a compilation, unless --quiet."""
    import logging

    class Notes(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            print(f"note: {record.getMessage()}", file=sys.stderr, flush=True)

    log = logging.getLogger("servosight")
    set_amount(quiet=args.quiet, verbose=args.verbose)
    log.handlers = [] if args.quiet else [Notes()]
    log.setLevel(logging.INFO)


def next_command(*words: object) -> str:
    """The line that suggests a command, with names quoted as a shell needs them."""
    return f"Next: servosight {shlex.join(map(str, words))}"


def made(args: argparse.Namespace) -> dict[str, Any]:
    """When and by which command line: what a report says of itself."""
    return {"at": datetime.now().astimezone(), "command": args.command_line}
