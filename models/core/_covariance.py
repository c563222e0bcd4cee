"""The covariance of a model's parameters, as its card keeps it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from servosight.models.core._arrays import Array


def kept_covariance(
    provenance: Mapping[str, Any], parameters: Collection[str]
) -> tuple[tuple[str, ...], Array] | None:
    """Names and values (names, names) of the covariance that ``identify`` left in a card.

    None where there is none, or where it is not whole or names others than the card's
    ``parameters``: the table is the user's to edit.

    >>> card = {"covariance": {"names": ["k"], "values": [[0.01]]}}
    >>> names, values = kept_covariance(card, ["k", "T", "xi", "bias"])
    >>> names, values.tolist()
    (('k',), [[0.01]])
    >>> kept_covariance({"covariance": {"names": ["k", "T"], "values": [[0.01]]}}, ["k", "T"])
    """
    table = provenance.get("covariance")
    if not isinstance(table, Mapping):
        return None
    names: Any = table.get("names")
    values: Any = table.get("values")
    try:
        matrix = np.asarray(values, dtype=np.float64)
        whole = matrix.shape == (len(names), len(names)) and bool(np.isfinite(matrix).all())
        whole = whole and set(names) <= set(parameters)
    except (TypeError, ValueError):
        return None
    return (tuple(names), matrix) if whole else None
