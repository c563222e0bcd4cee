"""The parser of all commands."""

from __future__ import annotations

import argparse
import itertools
import re
import sys
from typing import NoReturn

from servosight import __version__
from servosight.app.arguments import add_general
from servosight.app.commands import COMMANDS
from servosight.models.base import InputError, did_you_mean


class CommandParser(argparse.ArgumentParser):
    """A parser that says in one sentence what is wrong, and never exits for it."""

    def parse_known_args(self, args=None, namespace=None):  # type: ignore[no-untyped-def]
        """As argparse does; what a command does not know is its own error, not the program's."""
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            given = sys.argv[1:] if args is None else list(args)
            again = self._again(given, unknown[0])
            if again or not self._take(unknown, found):
                more = again or self._valueless(given, unknown[0])
                self.error(f"unrecognized arguments: {' '.join(unknown)}{more}")
        return found, []

    def _take(self, words: list[str], found: argparse.Namespace) -> bool:
        """Whether ``words``, from behind an option, are further values of what takes any number."""
        lists = [action for action in self._get_positional_actions() if action.nargs in ("+", "*")]
        if not lists or any(word.startswith("-") for word in words):
            return False
        try:
            further = [self._get_value(lists[0], word) for word in words]
        except argparse.ArgumentError as error:
            self.error(str(error))
        setattr(found, lists[0].dest, [*(getattr(found, lists[0].dest) or []), *further])
        return True

    def _again(self, args: list[str], word: str) -> str:
        """How to give a second value to an option that takes one at a time; empty for others."""
        for option, value, further in zip(args, args[1:], args[2:], strict=False):
            action = self._option_string_actions.get(option)
            repeated = isinstance(action, argparse._AppendAction)
            if further == word and repeated and not word.startswith("-"):
                return f"; repeat the option for each: {option} {value} {option} {word}"
        return ""

    def _valueless(self, args: list[str], word: str) -> str:
        """What an option does that takes no value and stands before one; empty for others."""
        for option, further in itertools.pairwise(args if not word.startswith("-") else ()):
            action = self._option_string_actions.get(option)
            if further == word and action is not None and action.nargs == 0:
                return f"; {option} takes no value ({self._help_of(action)})"
        return ""

    def error(self, message: str) -> NoReturn:
        """Raise InputError in place of printing the usage and exiting."""
        more = self._meant(message) or self._wanted(message)
        raise InputError(f"{message}{more}; see `{self.prog} --help`")

    def _meant(self, message: str) -> str:
        """The command, action or option that a misspelt one is closest to."""
        command = re.match(r"argument (?:COMMAND|ACTION): invalid choice: '(.*?)'", message)
        option = re.match(r"unrecognized arguments: --([^ =]+)", message)
        if command:
            return did_you_mean(command[1], self._commands())
        names = [name[2:] for name in self._option_string_actions if name.startswith("--")]
        return did_you_mean(option[1], names, prefix="--") if option else ""

    def _commands(self) -> list[str]:
        """The words that a parser below this one goes by."""
        below = [one for one in self._actions if isinstance(one, argparse._SubParsersAction)]
        return [name for one in below for name in one.choices]

    def _wanted(self, message: str) -> str:
        """What an option takes that was given without it, as its help says."""
        option = re.match(r"argument (?:\S+/)?(\S+): expected one argument", message)
        if option is None:
            return ""
        action = self._option_string_actions[option[1]]
        value = action.metavar or "|".join(map(str, action.choices or [action.dest.upper()]))
        return f", {value} ({self._help_of(action)})"

    def _help_of(self, action: argparse.Action) -> str:
        """What an option's help says, with its default."""
        return self._get_formatter()._expand_help(action)


def parser() -> argparse.ArgumentParser:
    """The parser of all commands."""
    top = CommandParser(
        prog="servosight",
        description="Identify the model of a servo from its video, and find what the model lacks.",
        epilog="A first look: servosight demo -o out/demo",
        allow_abbrev=False,
    )
    top.add_argument("--version", action="version", version=f"servosight {__version__}")
    add_general(top)
    commands = top.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, command in COMMANDS.items():
        words = (command.__doc__ or "").strip().splitlines()[0]
        sub = commands.add_parser(name, help=words, description=words, allow_abbrev=False)
        # Suppressed, so that their absence here does not undo what stands before the command.
        add_general(sub, argparse.SUPPRESS)
        command.configure(sub)
        sub.set_defaults(run=command.run)
    return top
