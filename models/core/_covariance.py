"""The covariance of a model's parameters in the provenance of its card."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from servosight.models.core._arrays import Array


def covariance_to_keep(names: Sequence[str], values: Array) -> dict[str, Any]:
    """What a provenance holds of a covariance (names, names): those that are known.

    Empty where none is, or where one that is known has an unknown covariance with another.

    >>> covariance_to_keep(["k", "T"], np.array([[0.01, np.nan], [np.nan, np.nan]]))
    {'covariance': {'names': ['k'], 'values': [[0.01]]}}
    """
    known = np.isfinite(np.diag(values))
    kept = values[np.ix_(known, known)]
    if not known.any() or not np.isfinite(kept).all():
        return {}
    shown = [name for name, one in zip(names, known, strict=True) if one]
    return {"covariance": {"names": shown, "values": kept.tolist()}}


def kept_covariance(
    provenance: Mapping[str, Any], parameters: Collection[str]
) -> tuple[tuple[str, ...], Array] | None:
    """Names and values (names, names) of the covariance that a fit left in a card.

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
