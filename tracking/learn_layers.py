"""From a first pass over stretches of the video to the layers, if they tell more than the surface.

The first pass measures on pixels well inside the surface. Stretches of neighbouring frames rather
than single ones, so that each frame's speed, and with it its smear and its rows' times, is known.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from servosight.tracking.fit import Fit, gauss_newton, turn_and_shift
from servosight.tracking.follow import Seen, Stage, follow
from servosight.tracking.layer_fit import learn_layers
from servosight.tracking.layered import Layered
from servosight.tracking.layers import Layers
from servosight.tracking.polar import Array, Pixels, Sample
from servosight.tracking.refine import Refine
from servosight.tracking.shutter import Exposure, Shutter
from servosight.tracking.surface import Image, Surface, pivot_error
from servosight.tracking.video import stretches

_STRETCHES = 8
_LENGTH = 48
_FROM_EACH = 12
_LEAST = 12
_BLURRED_PX = 2.0  # smear at the tip that a learnt picture may hold
_KEPT = 0.9
_JUDGES = 5  # of so many frames one judges
_GAIN = 1.0
_ROUNDS = 4
_SETTLED_PX = 0.002
_THINNING = 3  # of so many pixels one is enough for the first pass


def layered_stage(video: Path, refine: Refine, shutter: Callable[[int], Shutter]) -> Stage:
    """The layered stage, or ``refine`` where the layers do not tell the angle better."""
    chosen: list[Seen] = []
    radius = refine.surface.grid.largest_px
    rough = refine.thinned(_THINNING)
    for stretch in stretches(video, _STRETCHES, _LENGTH):
        home = rough.anywhere(stretch[0].image, 0.0, np.pi)
        seen = [
            s for s in follow(rough, stretch, home, shutter, radius) if s.fit and not s.repeated
        ]
        chosen += _slowest(seen, _FROM_EACH)
    chosen = [
        s
        for s in chosen
        if s.fit and s.fit.kept > _KEPT and s.exposure.turn_rad * radius < _BLURRED_PX
    ]
    if len(chosen) < _LEAST:
        return refine
    chosen.sort(key=lambda s: s.angle_rad)
    judges, taught = chosen[::_JUDGES], [s for n, s in enumerate(chosen) if n % _JUDGES]
    stage = Layered.of(_learnt(taught, refine.surface), refine)
    before, after = [], []
    for judge in judges:
        fit = stage.near(judge.frame.image, judge.angle_rad, judge.exposure)
        inside = refine.near(judge.frame.image, judge.angle_rad, judge.exposure)
        before.append(inside.sigma_rad if inside else np.inf)
        after.append(fit.sigma_rad if fit else np.inf)
    return stage if np.median(after) < _GAIN * np.median(before) else refine


def _learnt(taught: list[Seen], surface: Surface) -> Layers:
    """The layers of some frames, with angles and pivot made exact on the way.

    Pixels well inside leave the pivot uncertain by some thousandths of a pixel, which the outline
    tells better: fits with a shift give it as in ``surface.learn``.
    """
    images = [seen.frame.image for seen in taught]
    angles = np.array([seen.angle_rad for seen in taught])
    exposures = [seen.exposure for seen in taught]
    layers = learn_layers(images, angles, exposures, surface)
    for _ in range(_ROUNDS):
        fits = _shifted(layers, images, angles, exposures)
        known = np.array([fit is not None for fit in fits])
        angles = np.array([f.angle_rad if f else a for f, a in zip(fits, angles, strict=True)])
        shifts = np.array([fit.shift_px if fit else (0.0, 0.0) for fit in fits])
        moved, _ = pivot_error(angles[known], shifts[known])
        pivot = surface.pivot_px[0] + moved[0], surface.pivot_px[1] + moved[1]
        surface = replace(surface, grid=replace(surface.grid, pivot_px=pivot))
        layers = learn_layers(images, angles, exposures, surface, layers)
        if np.hypot(*moved) < _SETTLED_PX:
            break
    return layers


def _shifted(
    layers: Layers, images: list[Image], angles_rad: Array, exposures: list[Exposure]
) -> list[Fit | None]:
    pixels = Pixels.about(layers.grid, images[0].shape)
    radial = layers.along_radius()

    def fit(image: Image, angle_rad: float, exposure: Exposure) -> Fit | None:
        columns = exposure.smear_rad / layers.grid.step_rad
        shown, slope = (
            model.smeared(columns).about(pixels, angle_rad, exposure) for model in (layers, radial)
        )

        def at(angle: float) -> Sample:
            return replace(shown.at(angle), per_px=slope.at(angle).value)

        return gauss_newton(at, turn_and_shift, image, angle_rad, layers.shot)

    return [fit(*one) for one in zip(images, angles_rad.tolist(), exposures, strict=True)]


def _slowest(seen: list[Seen], count: int) -> list[Seen]:
    """Of each of ``count`` groups of near angles, the frame that moved least while exposed."""
    ordered = sorted(seen, key=lambda s: s.angle_rad)
    groups = np.array_split(np.arange(len(ordered)), count)
    return [
        min((ordered[i] for i in group), key=lambda s: s.exposure.turn_rad + s.exposure.slack_rad)
        for group in groups
        if group.size
    ]
