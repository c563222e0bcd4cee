"""``python benchmarks/paper``: see command.py."""

import sys
from pathlib import Path

sys.path[0] = str(Path(__file__).resolve().parents[1])  # this folder is the package ``paper``

from paper.command import main

if __name__ == "__main__":
    main(sys.argv[1:])
