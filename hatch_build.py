"""Build hook: on an editable install, link each source folder into ``src/servosight/``.

The sources stand in top-level folders and are imported as ``servosight.<folder>``. A wheel gets
there by ``[tool.hatch.build.targets.wheel.sources]``; an editable install has no such mapping that
mypy, pyright and the interpreter all understand, so it gets links instead. Git ignores them.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

PACKAGE = "servosight"


def mapped_folders(sources: dict[str, str]) -> list[str]:
    """Return the top-level folders that are imported under the package's name."""
    return sorted(folder for folder, target in sources.items() if target == f"{PACKAGE}/{folder}")


def link(folder: Path, place: Path) -> None:
    """Make ``place`` a link to ``folder``: relative, or a directory junction on Windows."""
    if place.is_symlink() or place.exists():
        if place.resolve() == folder.resolve():
            return
        if not place.is_symlink():
            raise RuntimeError(
                f"{place} is in the way: remove it, a link to {folder} belongs there"
            )
        place.unlink()
    if sys.platform == "win32":
        import _winapi

        _winapi.CreateJunction(str(folder), str(place))
    else:
        try:
            place.symlink_to(os.path.relpath(folder, place.parent), target_is_directory=True)
        except FileExistsError:  # another build of the same tree was faster
            if place.resolve() != folder.resolve():
                raise


class LinkSources(BuildHookInterface):  # type: ignore[type-arg]
    """Links the source folders for an editable install; a normal wheel is left alone."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Make the links, and remove those whose folder is mapped no longer."""
        if version != "editable":
            return
        root = Path(self.root)
        package = root / "src" / PACKAGE
        folders = mapped_folders(self.build_config.target_config["sources"])
        for place in package.iterdir():
            if place.is_symlink() and place.name not in folders:
                place.unlink()
        for name in folders:
            link(root / name, package / name)
