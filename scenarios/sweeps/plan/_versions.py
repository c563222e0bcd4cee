"""What made a result: the text of the sources it rests on, and the versions of the packages."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterable
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

_PACKAGES = ("servosight", "numpy", "scipy", "numba", "llvmlite", "mujoco", "msgspec")
_VIDEO_PACKAGES = ("av", "opencv-python-headless", "pyrender", "PyOpenGL", "pillow")

_FOLDERS = ("models", "sim", "identify", "scenarios")
_DRAWN_ONLY = ("sweeps/run", "sweeps/answers")
"""Parts of ``scenarios`` that run cells or draw their results, and do not change any."""


@cache
def versions(*, video: bool = False) -> str:
    """Python and the packages that a result depends on, with their versions, in one text."""
    names = (*_PACKAGES, *_VIDEO_PACKAGES) if video else _PACKAGES
    found = [f"python {platform.python_version()}"]
    for name in names:
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            continue
    return ", ".join(found)


def content_digest(root: Path, places: Iterable[str], leave_out: Iterable[str] = ()) -> str:
    """A hash over Python files below ``root``, and those of folders: their names and their text."""
    total = hashlib.sha256()
    without = [root / place for place in leave_out]
    for place in places:
        path = root / place
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            if not any(file.is_relative_to(other) for other in without):
                total.update(f"{file.relative_to(root)}\0".encode())
                total.update(file.read_bytes())
    return total.hexdigest()[:16]


@cache
def code_digest(*, video: bool, diagnosing: bool) -> str:
    """A hash over the sources that a cell runs, and the versions of what they rest on."""
    import servosight

    folders = [*_FOLDERS, *(["diagnose"] if diagnosing else [])]
    folders += ["tracking", "sources"] if video else []
    root = Path(servosight.__path__[0])
    left_out = [f"scenarios/{place}" for place in _DRAWN_ONLY]
    text = content_digest(root, folders, left_out) + versions(video=video)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
