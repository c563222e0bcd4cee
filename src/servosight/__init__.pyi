from servosight._verbs import (
    add,
    compare,
    diagnose,
    effects,
    identify,
    load,
    read,
    results,
    simulate,
    sweep,
    track,
)
from servosight.diagnose import Comparison, Diagnosis
from servosight.diagnose.change import ServoChange
from servosight.identify.fit import Fit
from servosight.models.core import Actuator, InputError, Recording
from servosight.tracking.core import Track

__version__: str

__all__ = [
    "Actuator",
    "Comparison",
    "Diagnosis",
    "Fit",
    "InputError",
    "Recording",
    "ServoChange",
    "Track",
    "__version__",
    "add",
    "compare",
    "diagnose",
    "effects",
    "identify",
    "load",
    "read",
    "results",
    "simulate",
    "sweep",
    "track",
]
