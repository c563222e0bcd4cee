"""``python -m servosight.app`` is the command ``servosight``."""

import sys

from _servosight import main

sys.exit(main())
