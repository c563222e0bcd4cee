"""Recordings as the commands take them."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from servosight.app.terminal import progress

if TYPE_CHECKING:
    from servosight.identify.foreign import Interface
    from servosight.models.core import Recording


def load(paths: Sequence[Path], args: argparse.Namespace) -> list[Recording]:
    """All recordings in order, each horn's behind its surface's, with the given pulse widths."""
    from servosight.models.core import views
    from servosight.sources import Options, read, unit_hint

    options = Options(deg_per_us=args.deg_per_us, neutral_us=args.neutral_us)
    recordings = []
    for path in paths:
        with progress(f"reading {path}") as show:
            recordings.append(read(path, options, show))
        hint = unit_hint(recordings[-1])
        if hint is not None:
            print(f"note: {path}: {hint}", file=sys.stderr)
    return views(recordings)


def fmu_interface(args: argparse.Namespace, path: Path | str) -> Interface:
    """An FMU with the names that the options give its input and output."""
    from servosight.identify.foreign import Interface

    return Interface(Path(path), args.fmu_input, args.fmu_output)


def is_command(path: Path) -> bool:
    """True for a table without any angle."""
    from servosight.models.io import read_sheet

    if path.is_dir() or not path.exists():
        return False
    return not any(name.startswith("angle_") for name in read_sheet(path).header)
