"""What an FMU carries beside the model: values with their uncertainty."""

from __future__ import annotations

import numpy as np

from servosight.export.core import ExportRequest, number
from servosight.export.csource import layout_of, parameters_of, values_of
from servosight.models.core import Actuator, kept_covariance


def extras(request: ExportRequest) -> dict[str, str]:
    """Files by name: a table of values, their covariance where the model has it, a parameter set.

    The parameter set is of SSP 1.0 (System Structure and Parameterization).
    """
    layout = layout_of(request)
    bounds = parameters_of(layout)
    names, values = layout.names(), values_of(request.actuator, layout)
    rows, entries = ["name,value,sigma,unit"], []
    for name, value in zip(names, values, strict=True):
        known = request.actuator.parameters.get(name)
        sigma = "" if known is None or known.sigma is None else number(known.sigma)
        rows.append(f"{name},{number(value)},{sigma},{bounds[name].unit}")
        if np.isfinite(value):
            entries.append(
                f'    <ssv:Parameter name="{name}"><ssv:Real value="{number(value)}"/>'
                "</ssv:Parameter>"
            )
    ssv = (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" '
        f'version="1.0" name="{request.name}">\n  <ssv:Parameters>\n'
        + "\n".join(entries)
        + "\n  </ssv:Parameters>\n</ssv:ParameterSet>\n"
    )
    found = {"parameters.csv": "\n".join(rows) + "\n", "parameters.ssv": ssv}
    return found | _covariance(request.actuator)


def _covariance(actuator: Actuator) -> dict[str, str]:
    """The covariance that a fit left in a card's provenance, where it is whole."""
    kept = kept_covariance(actuator.provenance, actuator.parameters)
    if kept is None:
        return {}
    names, matrix = kept
    lines = [",".join(["name", *names])]
    lines += [",".join([name, *map(number, row)]) for name, row in zip(names, matrix, strict=True)]
    return {"covariance.csv": "\n".join(lines) + "\n"}
