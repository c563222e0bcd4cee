"""The C compiler at hand, and what it is called with."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
from collections.abc import Sequence

from servosight.models.core import InputError

TIME_S = 120.0
STANDARD = ("-std=c99", "-O2", "-ffp-contract=off")
"""No fused multiply-add: the angles are those of the plant kernel, bit by bit."""


def compiler() -> list[str] | None:
    """The words that call a C compiler: the variable CC, else cc, gcc or clang; None without."""
    chosen = shlex.split(os.environ.get("CC", ""))
    if chosen and shutil.which(chosen[0]):
        return chosen
    for name in ("cc", "gcc", "clang"):
        found = shutil.which(name)
        if found:
            return [found]
    return None


def missing() -> str | None:
    """Why nothing can be compiled here, and what to install; None where it can."""
    if compiler() is not None:
        return None
    return (
        "no C compiler was found, expected cc, gcc or clang: install one "
        "(on Debian and Ubuntu `apt install gcc libc6-dev`) or name it in the variable CC"
    )


def compile_c(words: Sequence[str]) -> None:
    """Run the compiler; InputError where there is none, RuntimeError where it refuses."""
    chosen = compiler()
    if chosen is None:
        raise InputError(str(missing()))
    done = subprocess.run(
        [*chosen, *STANDARD, *words], capture_output=True, text=True, timeout=TIME_S, check=False
    )
    if done.returncode != 0:
        said = " ".join(done.stderr.split())[:500]
        raise RuntimeError(f"{chosen[0]} refused what was written ({said}); nothing was kept")
