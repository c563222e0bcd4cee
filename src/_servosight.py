"""The command's entry point: Ctrl-C ends it from here on, before anything else is imported.

Importing the package takes a tenth of a second, in which Python's own handler would show a
traceback. This stands beside the package because a module within would import that first. Once the
command's frame is there, ``servosight.app.interrupt`` takes over.
"""

import _signal  # type: ignore[import-not-found]  # built in: it takes no time to import
import os
import sys


def _leave(number: int, frame: object) -> None:
    os._exit(128 + number)


# An ignored signal stays ignored, as under nohup.
if _signal.getsignal(_signal.SIGINT) is _signal.default_int_handler:
    _signal.signal(_signal.SIGINT, _leave)


def main() -> int:
    """Run the command that the process was started with; returns the exit code."""
    from servosight.app.main import main

    return main()


if __name__ == "__main__":
    sys.exit(main())
