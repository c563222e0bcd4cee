"""The commands, one file each, by what they handle: ``configure(parser)`` and ``run(args)``.

The first line of a file's docstring is its help. Nothing heavy is imported at the top of them.
"""

from __future__ import annotations

from types import ModuleType

from servosight.app.commands import bench
from servosight.app.commands.about import completion, demo, effects
from servosight.app.commands.model import (
    add,
    compare,
    diagnose,
    export,
    identify,
    predict,
    report,
)
from servosight.app.commands.recording import calibrate, excite, import_log, simulate, track
from servosight.app.commands.sweeps import advise, results, sweep

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
    "export": export,
    "report": report,
    "effects": effects,
    "excite": excite,
    "sweep": sweep,
    "results": results,
    "advise": advise,
    "bench": bench,
    "completion": completion,
}
"""By name, in the order of the help."""
