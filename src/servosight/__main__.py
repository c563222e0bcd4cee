"""``python -m servosight`` is the command ``servosight``."""

import sys

from _servosight import main

if __name__ == "__main__":
    sys.exit(main())
