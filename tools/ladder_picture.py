"""The picture of the ladder in docs/search.md, from the folder of the README's demo.

    servosight demo -o out/demo --seed 2
    python tools/ladder_picture.py out/demo

writes docs/pictures/ladder.png.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

import servosight as ss

PICTURE = Path(__file__).resolve().parent.parent / "docs" / "pictures" / "ladder.png"


def main() -> None:
    """Draw it."""
    found: Any = ss.load(Path(sys.argv[1]) / "diagnosis.json")
    figure = Figure(figsize=(8.0, 3.8), layout="constrained")
    found.plot_ladder(ax=figure.subplots())
    figure.savefig(PICTURE, dpi=100)


if __name__ == "__main__":
    main()
