"""``ss.export``: a model as a file for other programs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from servosight._verbs._given import actuator_of, catalogue_of

if TYPE_CHECKING:
    from servosight._verbs._given import Model, Source
    from servosight.export.core import ExportResult


def export(
    model: Model,
    to: str,
    output: Path | str,
    *,
    on: Source | None = None,
    sample_time_s: float | None = None,
    transform: str = "tustin",
    stiffness_nm_rad: float = 1.0,
    plugins: Sequence[Path | str] = (),
) -> ExportResult:
    """Write a model as ``to`` (csv, header, control; docs/export.md has all kinds) to ``output``.

    The file is run in its target, where that is installed, on the recording ``on`` or a standard
    command, and compared with the model; the result holds the difference, and what the target
    cannot express. ``sample_time_s`` is that of a difference equation (default 0.01) or the time
    step of the simulator, ``transform`` (tustin, zoh, matched) how an equation is sampled.
    ``stiffness_nm_rad`` [N m/rad] of the position loop makes torques and inertia in mjcf. Raises
    InputError for a kind, a model or an option that is none.

    >>> import servosight as ss
    >>> fit = ss.identify(ss.simulate(seed=3), method="gradient")
    >>> result = ss.export(fit, "csv", "servo.csv", sample_time_s=0.004, transform="zoh")
    >>> result.difference_max_deg < 1e-6
    True
    """
    from servosight.export.core import ExportOptions, export_model
    from servosight.sources import read

    known = catalogue_of(plugins)
    given = None if on is None else read(on)
    return export_model(
        actuator_of(model, known),
        to,
        Path(output),
        effects=known,
        options=ExportOptions(
            sample_time_s=sample_time_s, transform=transform, stiffness_nm_rad=stiffness_nm_rad
        ),
        on=given,
    )
