"""What ``identify`` returns of an FMU."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from servosight.identify.uncertainty import Matrix
from servosight.models.core import Estimate, Result


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class FmuFit(Result):
    """Parameters of an FMU fitted to recordings; its fields are the keys of the JSON.

    ``parameters`` by their names in the ``model``, the FMU's file; the parameters of a recording of
    its own are one estimate or, for several recordings, one for each. ``covariance`` is that of the
    shared parameters. The other fields are those of a fit.
    """

    TYPE: ClassVar[str] = "fmu_fit"

    model: str
    parameters: Mapping[str, Estimate | tuple[Estimate, ...]]
    covariance: Matrix
    rmse_deg: float
    noise_deg: float
    floor_deg: float
    samples: int
    method: str
    seconds: float
    stopped: str
    warnings: tuple[str, ...] = ()
    fixed: tuple[str, ...] = ()
    recordings: tuple[str, ...] = ()
    paths: tuple[Path | None, ...] = ()
    evaluations: int = 0
