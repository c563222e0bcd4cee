# /// script
# requires-python = ">=3.11"
# dependencies = ["sysidentpy==0.9.0", "pandas<3"]
# ///
"""SysIdentPy on a record: columns command and angle in, times and free-run errors out as JSON.

It stands alone because SysIdentPy 0.9.0 wants an older numpy than servosight's lock has.
"""

from __future__ import annotations

import json
import sys
import time
from importlib.metadata import version

import numpy as np
from sysidentpy.basis_function import Polynomial
from sysidentpy.model_structure_selection import FROLS
from sysidentpy.parameter_estimation import LeastSquares

LAG = 2


def fitted(degree: int, command: np.ndarray, angle: np.ndarray) -> FROLS:
    """A polynomial NARX model, its terms chosen by forward regression."""
    terms = {1: 2 * LAG, 2: 8}[degree]
    model = FROLS(
        order_selection=False,
        n_terms=terms,
        ylag=LAG,
        xlag=LAG,
        estimator=LeastSquares(),
        basis_function=Polynomial(degree=degree),
    )
    model.fit(X=command, y=angle)
    return model


def main() -> None:
    """Fit twice, the second time measured; the first call loads libraries."""
    command, angle = (column[:, None] for column in np.loadtxt(sys.argv[1]).T)
    found = []
    for degree in (1, 2):
        fitted(degree, command, angle)
        began = time.process_time()
        model = fitted(degree, command, angle)
        seconds = time.process_time() - began
        error = angle - model.predict(X=command, y=angle[:LAG])
        name = f"SysIdentPy {version('sysidentpy')}, NARX degree {degree}"
        rmse = float(np.sqrt(np.mean(error**2)))
        found.append({"name": name, "seconds": seconds, "rmse_deg": rmse})
    print(json.dumps(found))


if __name__ == "__main__":
    main()
