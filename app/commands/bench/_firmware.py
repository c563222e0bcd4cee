"""Compile the firmware of a board, and say how to write it onto the board."""

from __future__ import annotations

import argparse
import shlex
from urllib.parse import urlsplit

from servosight.app.terminal import console

_PORT = "/dev/ttyUSB0"


def run(args: argparse.Namespace) -> None:
    """Source, program and the line that writes it; nothing is sent to a board."""
    from servosight.bench.firmware import FIRMWARE_FILES, build_firmware
    from servosight.models.core import new_folder

    with new_folder(args.output, FIRMWARE_FILES, sign="board.hex", force=args.force) as fresh:
        build_firmware(fresh)
    out = console(args)
    for name in FIRMWARE_FILES:
        out.print(f"{args.output / name}")
    port = urlsplit(args.servo).path if args.servo else ""
    place = shlex.quote(f"flash:w:{args.output / 'board.hex'}")
    line = f"avrdude -p m328p -c arduino -b 115200 -P {shlex.quote(port or _PORT)} -U {place}"
    out.print(
        f"Write it to an Arduino Uno or Nano (an old Nano: -b 57600):\n  {line}", soft_wrap=True
    )
