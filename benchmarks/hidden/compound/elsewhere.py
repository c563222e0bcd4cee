"""What the model that a diagnosis found has for parameters in other runs of the same servo."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .draw import CompoundSetup
from .facts import fit_from, logs

RUNS = tuple(f"reference {number}" for number in range(8))
"""Neither of them is diagnosed."""


def elsewhere(
    setup: CompoundSetup,
    effects: Sequence[str],
    parameters: Mapping[str, float],
    held: Sequence[str],
) -> dict[str, float]:
    """The parameters of ``effects`` with the linear core, fitted to eight runs without noise.

    The descent begins at ``parameters``, and those of ``held`` stay. The runs are fitted together:
    their own misfits average out, as far as those of eight runs do.
    """
    recordings = [log.ideal for run in RUNS for log in logs(setup, run, "fit", faults=False)]
    fit = fit_from(recordings, effects, parameters, {name: parameters[name] for name in held})
    return fit.problem.values(fit.outcome.point)
