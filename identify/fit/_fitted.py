"""What every fit returns, whichever the model: parameters, their covariance and the error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from servosight.identify.uncertainty import Matrix
from servosight.models.core import Estimate, Result


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class FittedParameters(Result):
    """Parameters fitted to recordings, and how well; a base, without a ``TYPE`` of its own.

    ``parameters`` by name; one that each recording has of its own is one estimate or, for several
    recordings, one for each. ``fixed`` names those that were held, whose sigma is 0. ``covariance``
    is that of the shared parameters in their own units. ``rmse_deg`` is the error over the
    ``samples`` that were scored, and ``fit_percent`` compares it with the motion (100 %: no error;
    None in results of earlier versions). ``noise_deg`` is the measurement's, and ``floor_deg``
    noise and tolerance together. ``paths`` says where each recording was read from. ``stopped``
    says why the search ended, and ``evaluations`` counts its simulations.
    """

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
    fit_percent: float | None = None

    @property
    def correlation(self) -> Matrix:
        """Correlation of the shared parameters."""
        return self.covariance.correlation

    def _paths(self) -> Sequence[Path | None]:
        return self.paths
