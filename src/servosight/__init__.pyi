from servosight._verbs import (
    add,
    bench,
    compare,
    diagnose,
    effects,
    export,
    identify,
    load,
    predict,
    read,
    results,
    simulate,
    sweep,
    track,
)
from servosight.diagnose import Comparison, Diagnosis
from servosight.diagnose.change import ServoChange
from servosight.export.core import ExportResult
from servosight.identify.fit import Fit
from servosight.models.core import Actuator, InputError, Recording
from servosight.tracking.core import Track

__version__: str

__all__ = [
    "Actuator",
    "Comparison",
    "Diagnosis",
    "ExportResult",
    "Fit",
    "InputError",
    "Recording",
    "ServoChange",
    "Track",
    "__version__",
    "add",
    "bench",
    "compare",
    "diagnose",
    "effects",
    "export",
    "identify",
    "load",
    "predict",
    "read",
    "results",
    "simulate",
    "sweep",
    "track",
]
