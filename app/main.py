"""The command line's frame: arguments in, an exit code out, one sentence for what goes wrong.

Exit codes: 0 done, whatever the verdict; 2 bad input or usage; 1 an error of the program; 130
interrupted. Heavy modules are imported inside the commands, so that help comes at once.
"""

from __future__ import annotations

import argparse
import os
import sys
import traceback
from collections.abc import Sequence
from typing import NoReturn

from servosight import __version__
from servosight.app.commands import COMMANDS
from servosight.models.core import InputError

DONE, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


class Parser(argparse.ArgumentParser):
    """A parser that says in one sentence what is wrong, and never exits for it."""

    def error(self, message: str) -> NoReturn:
        """Raise InputError in place of printing the usage and exiting."""
        raise InputError(f"{message}; see `{self.prog} --help`")


def parser() -> argparse.ArgumentParser:
    """The parser of all commands."""
    top = Parser(
        prog="servosight",
        description="Turn the video of a servo into its model, and learn what the model lacks.",
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
        command.configure(sub)
        sub.set_defaults(run=command.run)
    return top


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code."""
    words = sys.argv[1:] if argv is None else list(argv)
    debug = "--debug" in words
    # The threads are the simulations' own: a second pool that waits for work slows them twofold.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        args = parser().parse_args(words)
        args.run(args)
        sys.stdout.flush()
    except InputError as error:
        return _complain(str(error), BAD_INPUT, debug)
    except SystemExit as leaving:  # --help and --version
        return leaving.code if isinstance(leaving.code, int) else DONE
    except KeyboardInterrupt:
        return _complain("interrupted", INTERRUPTED, debug)
    except BrokenPipeError:  # the reader, such as `head`, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except Exception as error:
        what = f"{type(error).__name__}: {error}".rstrip(": ")
        hint = "" if debug else "; run it again with --debug for the traceback"
        return _complain(f"error of the program ({what}){hint}", FAILED, debug)
    return DONE


def _complain(sentence: str, code: int, debug: bool) -> int:
    if debug:
        traceback.print_exc()
    print(f"servosight: {' '.join(sentence.splitlines())}", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())
