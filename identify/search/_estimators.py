"""The registry of estimators, as ``--method`` names them.

A new one costs a file with a class that has ``ask``, ``tell`` and ``stopped``, and a line here; a
population operator, a file and a line in ``OPERATORS``. The
contract tests then run it: the same seed gives the same run, bounds and budget are kept, a batch
equals its members one by one, and the end has a reason.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from servosight.identify.search._estimator import Estimator, SearchSpace
from servosight.identify.search._levenberg_marquardt import gradient
from servosight.identify.search._memetic import memetic
from servosight.identify.search._population import OPERATORS

ESTIMATORS: Mapping[str, Callable[[SearchSpace], Estimator]] = {
    **{name: memetic(name) for name in OPERATORS},
    "gradient": gradient,
}
"""Estimators by name, each made from the space to search."""
