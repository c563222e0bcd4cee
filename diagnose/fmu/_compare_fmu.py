"""An FMU against recordings, as :func:`compare` holds a model card against them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from servosight.diagnose._compare import Comparison, compare
from servosight.identify.foreign import Interface, surrounded
from servosight.models.core import Estimate, Recording
from servosight.models.effects import catalogue


def compare_fmu(
    interface: Interface,
    recordings: Sequence[Recording],
    *,
    trust: bool = False,
    tolerance: float | None = None,
) -> Comparison:
    """Run the FMU on each recording, in a process of its own.

    Its parameters are as its file has them; the zero of the angle is found on each recording, and
    so is the initial state where the FMU has parameters named ``initial_angle`` and
    ``initial_speed``. The result remembers recordings and FMU, so that it can be drawn and
    reported. Raises InputError where ``trust`` is not given, and for whatever keeps the FMU from
    running.
    """
    with surrounded(interface, catalogue(), recordings, trust=trust) as model:
        found = compare(model.actuator, recordings, catalogue=model.catalogue, tolerance=tolerance)
        parameters = {
            one.name: Estimate(float(one.start or 0.0), None, one.unit)
            for one in model.model.parameters
        }
    return replace(found, parameters=parameters).remember(recordings, model.catalogue)
