"""The commands, one file each, with ``configure(parser)`` and ``run(args)``.

The first line of a file's docstring is its help. Nothing heavy is imported at the top of them.
"""

from __future__ import annotations

from types import ModuleType

from servosight.app.commands import (
    add,
    calibrate,
    compare,
    completion,
    demo,
    diagnose,
    effects,
    excite,
    identify,
    import_log,
    predict,
    report,
    simulate,
    track,
)

COMMANDS: dict[str, ModuleType] = {
    "demo": demo,
    "simulate": simulate,
    "import": import_log,
    "track": track,
    "calibrate": calibrate,
    "identify": identify,
    "compare": compare,
    "diagnose": diagnose,
    "add": add,
    "predict": predict,
    "report": report,
    "effects": effects,
    "excite": excite,
    "completion": completion,
}
"""By name, in the order of the help."""
