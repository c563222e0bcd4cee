"""Compile the firmware with avr-gcc."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from servosight.models.core import InputError

FIRMWARE_FILES = ("board.c", "board.elf", "board.hex")
"""What ``build_firmware`` leaves: the source, the program for debuggers, the program to write."""
_FLAGS = (
    "-mmcu=atmega328p",
    "-DF_CPU=16000000UL",
    "-std=c11",
    "-Os",
    "-Wall",
    "-Wextra",
    "-Werror",
)
_PACKAGES = "install the packages gcc-avr and avr-libc"


def firmware_source() -> Path:
    """The C source of the firmware.

    >>> firmware_source().name
    'board.c'
    """
    return Path(__file__).with_name("board.c")


def build_firmware(folder: Path) -> Path:
    """Write ``FIRMWARE_FILES`` into ``folder``; return the program for debuggers.

    InputError where avr-gcc or its library is not installed.
    """
    if shutil.which("avr-gcc") is None:
        raise InputError(
            f"avr-gcc is not installed, expected it for compiling the firmware; {_PACKAGES}"
        )
    source, elf, hexa = (folder / name for name in FIRMWARE_FILES)
    shutil.copyfile(firmware_source(), source)
    _call("avr-gcc", *_FLAGS, "-o", str(elf), str(source))
    _call("avr-objcopy", "-O", "ihex", "-R", ".eeprom", str(elf), str(hexa))
    return elf


def _call(*words: str) -> None:
    try:
        done = subprocess.run(words, capture_output=True, text=True, errors="replace")
    except OSError as error:
        raise InputError(f"{words[0]}: cannot be run ({error.strerror}); {_PACKAGES}") from None
    if done.returncode != 0:
        said = next((line for line in done.stderr.splitlines() if "error" in line), done.stderr)
        raise InputError(
            f"{words[0]}: does not compile the firmware ({said.strip()[:200]}), expected avr-libc "
            f"beside it; {_PACKAGES}"
        )
