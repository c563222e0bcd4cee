"""Recordings whose commands act once a frame, as in servos that are driven by pulses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from servosight.diagnose.selection._own_latency import fitted_to_all
from servosight.diagnose.selection.trials import ModelSelection, Trial
from servosight.identify.fit import FRAMES_GAIN, FramedFit, clear_frames
from servosight.identify.foreign import is_around_fmu

FRAMES_REMEDY = (
    "it is diagnosed with such frames: give {keys} in its recording.toml, as recordings for the "
    "test alone need them there"
)


def command_frames(
    models: ModelSelection,
    model: Trial,
    runs: Sequence[int],
    floor_deg: float,
    gain: float = FRAMES_GAIN,
) -> FramedFit | None:
    """The frames of the fitted and the carried recordings where they are clear beside a model: with
    them its error is less by the share ``gain``.

    Seen in the samples that fit and choose, never in those of the test. ``runs`` (recordings,)
    numbers the run that each of them is a part of: parts of one share their frames. None of a model
    that is another program's, whose simulations are too slow to try hundreds.
    """
    if is_around_fmu(models.catalogue):
        return None
    found = clear_frames(fitted_to_all(models, model), floor_deg, gain)
    if found is None:
        return None
    of_run = {run: one for run, one in zip(runs, found.frames, strict=True) if one is not None}
    return replace(found, frames=tuple(of_run.get(run) for run in runs))
