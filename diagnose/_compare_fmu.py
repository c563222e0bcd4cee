"""An FMU against recordings, as :func:`compare` holds a model card against them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from servosight.diagnose._compare import Comparison, comparison_of
from servosight.diagnose.residuals import TEST, Judged
from servosight.identify.foreign import fitted_own, trusted
from servosight.identify.problem import thinned, usable_views
from servosight.models.core import Estimate, Recording
from servosight.models.fmu import FmuLimits, FmuModel, open_fmu


def compare_fmu(
    path: Path,
    recordings: Sequence[Recording],
    *,
    trust: bool = False,
    command: str | None = None,
    angle: str | None = None,
    tolerance: float | None = None,
    limits: FmuLimits | None = None,
) -> Comparison:
    """Run the FMU on each recording, in a process of its own.

    Its parameters are as its file has them. Where it has parameters named ``bias``,
    ``initial_angle`` and ``initial_speed`` they are found on each recording; without ``bias`` the
    zero of the angle is. ``command`` and ``angle`` name its input and output. Raises InputError
    where ``trust`` is not given, and for whatever keeps the FMU from running.
    """
    trusted(path, trust)
    scored, _ = thinned(usable_views(recordings)[0])
    with open_fmu(path, limits=limits) as fmu:
        model = FmuModel.of(fmu, command, angle)
        judged = tuple(
            Judged(one, fitted_own(model, one), np.full(one.time_s.size, TEST, dtype=np.int8))
            for one in scored
        )
        parameters = {
            one.name: Estimate(float(one.start or 0.0), None, one.unit) for one in model.parameters
        }
    return comparison_of(judged, recordings, (), parameters, tolerance)
