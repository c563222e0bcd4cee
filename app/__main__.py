"""``python -m servosight.app`` is the command ``servosight``."""

import sys

from servosight.app.main import main

sys.exit(main())
