"""Compile the firmware with avr-gcc."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from servosight.models.core import InputError

_FLAGS = (
    "-mmcu=atmega328p",
    "-DF_CPU=16000000UL",
    "-std=c11",
    "-Os",
    "-Wall",
    "-Wextra",
    "-Werror",
)


def firmware_source() -> Path:
    """The C source of the firmware.

    >>> firmware_source().name
    'board.c'
    """
    return Path(__file__).with_name("board.c")


def build_firmware(folder: Path) -> Path:
    """Compile the firmware into ``folder`` as board.elf and board.hex; return the first.

    InputError where avr-gcc is not installed.
    """
    if shutil.which("avr-gcc") is None:
        raise InputError(
            "avr-gcc is not installed, expected it for compiling the firmware; install the "
            "packages gcc-avr and avr-libc"
        )
    elf, hexa = folder / "board.elf", folder / "board.hex"
    subprocess.run(["avr-gcc", *_FLAGS, "-o", str(elf), str(firmware_source())], check=True)
    subprocess.run(["avr-objcopy", "-O", "ihex", "-R", ".eeprom", str(elf), str(hexa)], check=True)
    return elf
