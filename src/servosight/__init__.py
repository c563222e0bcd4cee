"""servosight: turn video of a servo into a model of its actuator.

>>> import servosight as ss
>>> recording = ss.simulate(effect="backlash", set={"backlash.gap": 1.5}, seed=3)
>>> fit = ss.identify(recording, effects=["backlash"])
>>> fit.parameters["backlash.gap"].unit
'deg'

Nothing heavy is loaded until it is used: numba with the first model, OpenCV with the first video,
MuJoCo with the first simulation. Angles are in degrees, times in seconds, arrays 1-D float64.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import Any

__version__ = "0.1.0"

_VERBS = (
    "read",
    "track",
    "identify",
    "compare",
    "diagnose",
    "add",
    "predict",
    "simulate",
    "effects",
    "load",
    "sweep",
    "results",
    "export",
)
_HOMES = {
    **{verb: ("servosight._verbs", verb) for verb in _VERBS},
    "bench": ("servosight._verbs", "bench"),
    "Recording": ("servosight.models.core", "Recording"),
    "Actuator": ("servosight.models.core", "Actuator"),
    "InputError": ("servosight.models.core", "InputError"),
    "Fit": ("servosight.identify.fit", "Fit"),
    "Comparison": ("servosight.diagnose", "Comparison"),
    "Diagnosis": ("servosight.diagnose", "Diagnosis"),
    "ServoChange": ("servosight.diagnose.change", "ServoChange"),
    "ExportResult": ("servosight.export.core", "ExportResult"),
    "Track": ("servosight.tracking.core", "Track"),
}
__all__ = ["__version__", *_HOMES]  # noqa: PLE0604, each is a string


def __getattr__(name: str) -> Any:
    """Load what is asked for, once. What there is stands in ``__init__.pyi`` as well."""
    if name not in _HOMES:
        raise AttributeError(f"module 'servosight' has no attribute {name!r}")
    home, own_name = _HOMES[name]
    value = getattr(import_module(home), own_name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)


class _Package(ModuleType):
    """Keeps the verbs ``identify`` and ``diagnose`` from the sub-packages of the same names.

    Importing a sub-package sets it as an attribute of the package; here that is left out, and
    ``from servosight.identify import ...`` works all the same.
    """

    def __setattr__(self, name: str, value: Any) -> None:
        if not (name in _HOMES and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
