"""What ``identify`` returns of an FMU."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from servosight.identify.fit import FittedParameters


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class FmuFit(FittedParameters):
    """Parameters of an FMU fitted to recordings; its fields are the keys of the JSON.

    ``parameters`` by their names in the ``model``, the FMU's file. The other fields are those of
    every fit.
    """

    TYPE: ClassVar[str] = "fmu_fit"

    model: str
