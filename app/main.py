"""The command line's frame: arguments in, an exit code out, one sentence for what goes wrong.

Exit codes: 0 done, whatever the verdict; 2 bad input or usage; 1 an error of the program; 130
interrupted by Ctrl-C, 143 by SIGTERM, 129 by SIGHUP. Signals are handled before anything else is
imported, and heavy modules are imported inside the commands, so that help comes at once.
"""

from __future__ import annotations

import errno
import os
import re
import shlex
import sys
from collections.abc import Sequence

from servosight.app import interrupt

DONE, FAILED, BAD_INPUT = 0, 1, 2
NO_ROOM = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; returns the exit code.

    Without ``argv`` the process is the command's own: signals, warnings and what native libraries
    write to standard error are handled for it.
    """
    if argv is not None:
        return _run(list(argv))
    words = sys.argv[1:]
    interrupt.install()
    try:
        if "--debug" not in words:
            _quieten()
        code = _run(words)
    except BaseException:
        if not interrupt.received():
            raise
        code = interrupt.exit_code()
    interrupt.leave(code)
    return code


def _run(words: list[str]) -> int:
    debug = "--debug" in words
    # The threads are the simulations' own: a second pool that waits for work slows them twofold.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    os.environ.setdefault("OPENCV_LOG_LEVEL", "SILENT")
    # pyrender draws; a context of MuJoCo's own, which a shell may ask for, fails with old PyOpenGL.
    os.environ["MUJOCO_GL"] = "disable"
    from servosight.models.base import InputError

    try:
        from servosight.app.completion import complete
        from servosight.app.parser import parser
        from servosight.app.terminal import ignore_closed_pipe, show_notes
        from servosight.models.base import discard_all

        interrupt.clean_with(discard_all)
        commands = parser()
        complete(commands)
        args = commands.parse_args(words)
        args.command_line = shlex.join(["servosight", *words])
        show_notes(args)
        args.run(args)
        sys.stdout.flush()
    except InputError as error:
        return _complain(str(error), BAD_INPUT, debug)
    except SystemExit as leaving:  # --help and --version
        return leaving.code if isinstance(leaving.code, int) else DONE
    except KeyboardInterrupt:
        return _complain("interrupted", interrupt.exit_code(), debug)
    except BrokenPipeError:
        ignore_closed_pipe(sys.stdout)
    except Exception as error:
        if isinstance(error, OSError) and error.errno in NO_ROOM:
            return _complain(_no_room(error), BAD_INPUT, debug)
        what = f"{type(error).__name__}: {error}".rstrip(": ")
        hint = "" if debug else "; run it again with --debug for the traceback"
        return _complain(f"error of the program ({what}){hint}", FAILED, debug)
    return DONE


def _no_room(error: OSError) -> str:
    """What to do where the disk is full, also for compiled code, which is kept for later runs."""
    where = error.filename or "a file to write"
    return f"{where}: expected room on its disk ({error.strerror}); free some, or raise the limit"


def _quieten() -> None:
    """Keep from the terminal what libraries write there past Python, and Python's warnings.

    Standard error gets a descriptor of its own; the one that native code writes to leads nowhere.
    """
    import io
    import warnings

    if not sys.warnoptions:
        warnings.simplefilter("ignore")
    try:
        own = os.dup(sys.stderr.fileno())
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 2)
        os.close(nowhere)
    except (AttributeError, OSError, ValueError):  # started without a standard error
        return
    sys.stderr = io.TextIOWrapper(
        os.fdopen(own, "wb", buffering=0),
        encoding=sys.stderr.encoding,
        errors="backslashreplace",
        line_buffering=True,
        write_through=True,
    )
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="backslashreplace")  # a name that is not UTF-8


def _complain(sentence: str, code: int, debug: bool) -> int:
    if interrupt.received():  # a module may have turned the interruption into an error of its own
        sentence, code = "interrupted", interrupt.exit_code()
    if debug:
        import traceback

        traceback.print_exc()
    sentence = re.sub(r"(\S{80})\S{80,}(\S{40})", r"\1...\2", " ".join(sentence.splitlines()))
    sentence = sentence.encode("utf-8", "backslashreplace").decode()
    print(f"servosight: {sentence}", file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())
