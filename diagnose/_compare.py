"""A given model against recordings, without fitting its physics anew."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from servosight.diagnose._report import write_report
from servosight.diagnose.residuals import (
    EXPLAINED,
    TEST,
    Finding,
    Judged,
    Window,
    findings,
    lead,
    rms,
    worst_windows,
)
from servosight.diagnose.result.wording import Levels, comparison_words
from servosight.diagnose.selection import predict_fixed
from servosight.identify.fit import floor_deg
from servosight.identify.foreign import fmu_actuator
from servosight.identify.problem import (
    Problem,
    joint_noise_deg,
    thinned,
    unused_disturbances,
    usable_views,
)
from servosight.models.core import (
    Actuator,
    Estimate,
    InputError,
    Recording,
    Result,
    Table,
    fit_percent,
    one_or_more,
    plot_prediction,
)
from servosight.models.effects import Effect
from servosight.models.effects import catalogue as built_in
from servosight.models.io import load_recording
from servosight.models.plant import to_the_end

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, kw_only=True)
class RecordingError:
    """The rms error on one recording, and where that was read from."""

    recording: str
    rmse_deg: float
    samples: int
    path: Path | None = None


@dataclass(frozen=True, kw_only=True, repr=False, eq=False)
class Comparison(Result):
    """A model's error on recordings that it need not have been fitted on.

    ``explained``: the error is at most 1.10 times ``floor_deg``, the smallest error that counts.
    ``sentences``: the error as a whole, then the findings, the largest first. ``fit_percent``
    compares the error with the motion (100 %: no error; None in results of earlier versions).

    >>> import servosight as ss
    >>> recording = ss.simulate(seed=3)
    >>> found = ss.compare(ss.identify(recording, method="gradient"), recording)
    >>> found.explained, found.rmse_deg < 1.1 * found.floor_deg, len(found.recordings)
    (True, True, 1)
    """

    TYPE: ClassVar[str] = "comparison"

    headline: str
    summary: str
    effects: tuple[str, ...]
    parameters: Mapping[str, Estimate]
    rmse_deg: float
    noise_deg: float
    tolerance_deg: float
    floor_deg: float
    explained: bool
    recordings: Table[RecordingError]
    where: Table[Window]
    findings: Table[Finding]
    sentences: tuple[str, ...]
    warnings: tuple[str, ...]
    fit_percent: float | None = None

    @property
    def actuator(self) -> Actuator:
        """The model that was compared."""
        return Actuator(self.parameters, self.effects)

    def report(
        self,
        path: Path | str,
        recordings: Any = None,
        *,
        catalogue: Mapping[str, Effect] | None = None,
    ) -> None:
        """Write a report to read in a browser.

        ``recordings`` are those compared, or their paths (default: those given, or where they
        were); ``catalogue`` is needed where a model that was read back has effects of a plugin.
        """
        write_report(path, self, recordings, catalogue)

    def plot(
        self,
        ax: Axes | None = None,
        *,
        number: int = 0,
        recordings: Recording | Sequence[Recording] | None = None,
    ) -> Axes:
        """Measured angle and model over time, the residual below; the worst moments are marked.

        ``number`` and ``recordings`` as for the plot of a fit.
        """
        given = self.sources() if recordings is None else recordings
        several = [given] if isinstance(given, Recording) else given
        read = [load_recording(one) if isinstance(one, Path) else one for one in several]
        model = fmu_actuator(self.known_effects or {}) or self.actuator
        judged = judge(model, read, catalogue=self.known_effects)
        if not 0 <= number < len(judged):
            raise InputError(f"plot: recording {number}, expected 0 to {len(judged) - 1}")
        one = judged[number]
        name = one.recording.name
        marked = [(w.start_s, w.end_s) for w in self.where if w.recording == name]
        predicted = one.recording.angle_deg - one.error_deg
        return plot_prediction(one.recording, predicted, self.floor_deg, ax, marked)

    def _paths(self) -> Sequence[Path | None]:
        return [one.path for one in self.recordings]


def compare(
    actuator: Actuator,
    recordings: Sequence[Recording],
    *,
    catalogue: Mapping[str, Effect] | None = None,
    tolerance: float | None = None,
) -> Comparison:
    """Simulate ``actuator`` on each recording.

    The physical parameters are the model's. Bias, initial angle and initial speed belong to each
    recording and are found on it. InputError where there is no recording, or for a ``tolerance``
    [deg] that is none.
    """
    judged = judge(actuator, recordings, catalogue=catalogue)
    return comparison_of(
        judged, recordings, actuator.effects, actuator.parameters, tolerance, catalogue=catalogue
    )


def comparison_of(
    judged: tuple[Judged, ...],
    recordings: Sequence[Recording],
    effects: tuple[str, ...],
    parameters: Mapping[str, Estimate],
    tolerance: float | None = None,
    *,
    catalogue: Mapping[str, Effect] | None = None,
) -> Comparison:
    """What predictions of the recordings say of the model that made them."""
    known = built_in() if catalogue is None else catalogue
    seen, left_out = usable_views(one_or_more(recordings))
    for one in judged:
        to_the_end(one.predicted_deg, one.recording)
    noise = joint_noise_deg(tuple(seen))
    floor = floor_deg(seen, noise, tolerance)
    _, notes = thinned(seen)
    found = findings(judged, floor, noise)
    rmse = rms([one.error_deg for one in judged])
    explained = rmse <= EXPLAINED * floor
    tolerance_deg = float(np.sqrt(max(floor**2 - noise**2, 0.0)))
    levels = Levels(noise_deg=noise, tolerance_deg=tolerance_deg, floor_deg=floor)
    headline, summary = comparison_words(rmse, explained, levels)
    return Comparison(
        headline=headline,
        summary=summary,
        effects=effects,
        parameters=parameters,
        rmse_deg=rmse,
        noise_deg=noise,
        tolerance_deg=tolerance_deg,
        floor_deg=floor,
        explained=explained,
        recordings=Table(
            RecordingError(
                recording=one.recording.name,
                rmse_deg=rms([one.error_deg]),
                samples=int(one.recording.time_s.size),
                path=one.recording.path,
            )
            for one in judged
        ),
        where=Table(worst_windows(judged)),
        findings=Table(found),
        sentences=(lead(judged, found, floor), *(one.sentence for one in found)),
        warnings=(*left_out, *unused_disturbances(seen, effects, known), *notes),
        fit_percent=fit_percent(rmse, [one.recording.angle_deg for one in judged], floor),
    )


def judge(
    actuator: Actuator,
    recordings: Sequence[Recording],
    *,
    catalogue: Mapping[str, Effect] | None = None,
) -> tuple[Judged, ...]:
    """The model's prediction of each recording, a horn's angle as one of its own.

    Of very long recordings every n-th sample is predicted.
    """
    effects = built_in() if catalogue is None else catalogue
    scored, _ = thinned(usable_views(one_or_more(recordings))[0])
    return tuple(_judge(actuator, recording, effects) for recording in scored)


def _judge(actuator: Actuator, recording: Recording, catalogue: Mapping[str, Effect]) -> Judged:
    problem = Problem.of([recording], catalogue, actuator.effects)
    predicted = predict_fixed(recording, problem, problem.shared_point(actuator.value))
    return Judged(recording, predicted, np.full(recording.time_s.size, TEST, dtype=np.int8))
