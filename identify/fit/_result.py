"""What ``identify`` returns: parameters with their uncertainty, as plain values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from servosight.identify.design import InformationSummary
from servosight.identify.fit._detectable import Detectable
from servosight.identify.fit._dynamics import Dynamics
from servosight.identify.fit._fitted import FittedParameters
from servosight.identify.fit._own import OwnValues, predicted_angle
from servosight.identify.problem import thinned, usable_views
from servosight.identify.transmission import Transmission
from servosight.models.core import (
    Actuator,
    Array,
    Estimate,
    InputError,
    Recording,
    Table,
    axes_of,
    covariance_to_keep,
    plot_prediction,
)
from servosight.models.effects import catalogue as built_in
from servosight.models.io import load_recording
from servosight.models.plant import Difference

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Fit(FittedParameters):
    """An actuator fitted to recordings; its fields are the keys of the JSON (docs/json.md).

    Beside what every fit has, ``own`` has a line for each recording, ``history`` (generations,) is
    the best cost after each generation of the search, and ``discrete`` the model as a difference
    equation. ``information`` says whether the command suffices, where that was asked for
    (:func:`with_information`). ``dynamics`` are bandwidth, step metrics and the like, and
    ``transmissions`` what lies between horn and surface, where both were measured.

    >>> from servosight.identify.fit import identify
    >>> from servosight.models.core import Recording
    >>> import numpy as np
    >>> time_s = np.arange(0.0, 4.0, 0.01)
    >>> command_deg = np.where(time_s % 1.0 < 0.5, 10.0, -10.0)
    >>> lagged = np.convolve(command_deg, np.full(10, 0.1))[: time_s.size]
    >>> fit = identify(Recording("steps", time_s, command_deg, time_s, lagged), method="gradient")
    >>> fit.parameters["k"].unit, len(fit.covariance.names), fit.samples
    ('-', 3, 400)
    """

    TYPE: ClassVar[str] = "fit"

    effects: tuple[str, ...] = ()
    own: tuple[OwnValues, ...] = ()
    history: Array
    discrete: Difference
    information: InformationSummary | None = None
    dynamics: Dynamics | None = None
    detectable: Table[Detectable] = field(default_factory=Table)
    transmissions: Table[Transmission] = field(default_factory=Table)

    @property
    def biases(self) -> tuple[Estimate, ...]:
        """The angle at zero command of each recording."""
        bias = self.parameters["bias"]
        return (bias,) if isinstance(bias, Estimate) else tuple(bias)

    @property
    def actuator(self) -> Actuator:
        """The model, with the first recording's bias."""
        shared = {name: one for name, one in self.parameters.items() if isinstance(one, Estimate)}
        return Actuator(
            {**shared, "bias": self.biases[0]},
            self.effects,
            {
                "fitted_on": list(self.recordings),
                "method": self.method,
                **covariance_to_keep(self.covariance.names, self.covariance.values),
            },
        )

    def plot(
        self,
        ax: Axes | None = None,
        *,
        number: int = 0,
        recordings: Recording | Sequence[Recording] | None = None,
    ) -> Axes:
        """Measured angle and model over time, the residual below.

        ``number`` says which of several recordings, from 0. ``recordings`` are those of the fit,
        where it does not know them itself: it was read back, and they were never in a file.
        Raises InputError then.
        """
        given = self.sources() if recordings is None else recordings
        several = [given] if isinstance(given, Recording) else given
        read = [load_recording(one) if isinstance(one, Path) else one for one in several]
        seen, _ = thinned(usable_views(read)[0])
        if [one.name for one in seen] != list(self.recordings) or not 0 <= number < len(seen):
            raise InputError(
                f"plot: recording {number} of {', '.join(one.name for one in seen)}; expected one "
                f"of the fit's, in their order: {', '.join(self.recordings)}"
            )
        known = built_in() if self.known_effects is None else self.known_effects
        one, own = seen[number], self.own[number]
        angle = predicted_angle(one, self.effects, self.parameters, own, known)
        return plot_prediction(one, angle, self.floor_deg, ax)

    def plot_correlations(self, ax: Axes | None = None) -> Axes:
        """The correlation of the shared parameters, from -1 to 1."""
        axes = axes_of(ax)
        found, names = self.correlation.values, self.correlation.names
        axes.imshow(found, vmin=-1.0, vmax=1.0, cmap="RdBu")
        for (row, column), value in np.ndenumerate(found):
            axes.text(column, row, f"{value:+.2f}", ha="center", va="center", fontsize=8)
        axes.set_xticks(range(len(names)), names, rotation=45, ha="right")
        axes.set_yticks(range(len(names)), names)
        axes.set_title("correlation of the parameters")
        return axes

    def save(self, path: Path | str) -> None:
        """Write the model's card where the name ends in .toml, else JSON."""
        if Path(path).suffix == ".toml":
            self.actuator.save(Path(path))
        else:
            super().save(path)


def parameter_table(
    shared: Mapping[str, Estimate], biases: tuple[Estimate, ...]
) -> dict[str, Estimate | tuple[Estimate, ...]]:
    """Parameters by name, ``bias`` as one estimate or, for several recordings, as a tuple."""
    return {**shared, "bias": biases[0] if len(biases) == 1 else biases}
