"""The parser of all commands."""

from __future__ import annotations

import argparse
import re
from typing import NoReturn

from servosight import __version__
from servosight.app.commands import COMMANDS
from servosight.models.base import InputError, did_you_mean


class CommandParser(argparse.ArgumentParser):
    """A parser that says in one sentence what is wrong, and never exits for it."""

    def error(self, message: str) -> NoReturn:
        """Raise InputError in place of printing the usage and exiting."""
        raise InputError(f"{message}{_meant(message)}; see `{self.prog} --help`")


def parser() -> argparse.ArgumentParser:
    """The parser of all commands."""
    top = CommandParser(
        prog="servosight",
        description="Identify the model of a servo from its video, and find what the model lacks.",
        epilog="A first look: servosight demo -o out/demo",
        allow_abbrev=False,
    )
    top.add_argument("--version", action="version", version=f"servosight {__version__}")
    top.add_argument("--debug", action="store_true", help="show the traceback of an error")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, command in COMMANDS.items():
        words = (command.__doc__ or "").strip().splitlines()[0]
        sub = commands.add_parser(name, help=words, description=words, allow_abbrev=False)
        # Suppressed, so that its absence here does not undo a --debug before the command.
        sub.add_argument(
            "--debug",
            action="store_true",
            default=argparse.SUPPRESS,
            help="show the traceback of an error",
        )
        amount = sub.add_mutually_exclusive_group()
        amount.add_argument(
            "-q", "--quiet", action="store_true", help="print nothing but JSON and errors"
        )
        amount.add_argument(
            "-v",
            "--verbose",
            action="store_true",
            help="report each stage and its duration on standard error",
        )
        command.configure(sub)
        sub.set_defaults(run=command.run)
    return top


def _meant(message: str) -> str:
    """The choice that a misspelt one is closest to."""
    found = re.match(r"argument COMMAND: invalid choice: '(.*?)'", message)
    return did_you_mean(found[1], COMMANDS) if found else ""
