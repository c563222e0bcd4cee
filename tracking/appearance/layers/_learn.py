"""From a first pass over a video to its layers, where these are better than the surface."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from servosight.tracking.appearance.layers._fine import LayerEstimator
from servosight.tracking.appearance.layers._fit import learn_layers
from servosight.tracking.appearance.surface import SurfaceEstimator
from servosight.tracking.fit import AngleEstimator, TrackedFrame

_FROM_EACH = 0.3  # of the frames of a whole run
_LEAST = 12
_BLURRED_PX = 14.0  # smear at the tip that learning can undo
_ENOUGH = 32
_KEPT = 0.9
_JUDGES = 5  # of so many frames one judges
_GAIN = 1.0


def layer_estimator(
    runs: Iterable[Sequence[TrackedFrame]], refine: SurfaceEstimator, run_frames: int
) -> AngleEstimator:
    """The layered stage by ``runs`` of up to ``run_frames`` neighbouring frames, or ``refine``
    where the layers do not determine the angle better."""
    chosen: list[TrackedFrame] = []
    radius = refine.surface.grid.largest_px
    for run in runs:
        seen = [replace(s, copied=None) for s in run if s.fit and not s.repeated]
        chosen += _slowest(seen, round(_FROM_EACH * run_frames))
    chosen = [
        s
        for s in chosen
        if s.fit and s.fit.kept > _KEPT and s.exposure.turn_rad * radius < _BLURRED_PX
    ]
    if len(chosen) < _LEAST:
        return refine
    chosen = _slowest(chosen, _ENOUGH)
    judges, taught = chosen[::_JUDGES], [s for n, s in enumerate(chosen) if n % _JUDGES]
    layers = learn_layers(
        [s.frame.image for s in taught],
        np.array([s.angle_rad for s in taught]),
        [s.exposure for s in taught],
        np.array([(s.fit.gain, s.fit.offset) for s in taught if s.fit]),
        refine.surface,
        float(np.median([s.fit.noise for s in taught if s.fit])),
    )
    stage = LayerEstimator.of(layers, refine)
    ratios = []
    for judge in judges:
        fit = stage.fit_near(judge.frame.image, judge.angle_rad, judge.exposure)
        inside = refine.fit_near(judge.frame.image, judge.angle_rad, judge.exposure)
        if inside is not None:
            ratios.append(fit.sigma_rad / inside.sigma_rad if fit else np.inf)
    return stage if not ratios or np.median(ratios) < _GAIN else refine


def _slowest(seen: list[TrackedFrame], count: int) -> list[TrackedFrame]:
    """Of each of ``count`` groups of near angles, the frame that moved least while exposed."""
    ordered = sorted(seen, key=lambda s: s.angle_rad)
    groups = np.array_split(np.arange(len(ordered)), count)
    return [
        min((ordered[i] for i in group), key=lambda s: s.exposure.turn_rad + s.exposure.slack_rad)
        for group in groups
        if group.size
    ]
