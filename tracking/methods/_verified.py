"""A track is returned only where the frames confirm it; what is refused comes with a picture."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial

import cv2
import numpy as np

from servosight.models.core import Array, Image, InputError, Mask, Single
from servosight.tracking.acquisition import POINT, swept
from servosight.tracking.core import Track, TrackOptions, TrackRefused
from servosight.tracking.verification import (
    FrameSample,
    TurningScene,
    at_scale,
    contradiction,
    evidence_of,
)
from servosight.tracking.video import Film
from servosight.tracking.video.drawing import SeenPart, refusal_picture

_LEAST_FRAMES = 8


@contextmanager
def refused_with_picture(film: Film) -> Iterator[None]:
    """Add a picture of what changes in the video to every refusal."""
    try:
        yield
    except TrackRefused:
        raise
    except InputError as error:
        raise TrackRefused(str(error), partial(refusal_picture, film.images)) from error


def verify(
    film: Film, options: TrackOptions, track: Track, flat_pivot: Array, outlines: Sequence[Array],
    sample: FrameSample, usable: Mask | None = None,
    draw: Callable[[], Image] | None = None,
    entering: Callable[[Single], Mask] | None = None,
) -> None:  # fmt: skip
    """Compare a track with a sample of the frames; ``TrackRefused`` where they contradict it.

    ``flat_pivot`` (2,) and ``outlines`` (points, 2), those of the part's pieces and of the holes in
    them, lie in the plane of motion, as the sample's pictures do. ``usable`` (frames,) marks the
    frames in which the part was looked for. ``draw`` makes the picture of a refusal; the part on
    the calm frames where None. ``entering`` marks in pictures (n, height, width) what enters them,
    which is not asked of the part.
    """
    tried = np.ones(track.frames, bool) if usable is None else usable
    chosen, pictures, rolls = sample.chosen(track.found)
    if len(chosen) < _LEAST_FRAMES:
        why: str | None = f"the part was found in only {track.found.mean():.0%} of the frames"
    else:
        scale = sample.scale
        # Integer pixel centres, before and after the change of size.
        pivot, *lines = (at_scale(points, scale) for points in (flat_pivot, *outlines))
        scene = TurningScene.of(
            pictures, np.deg2rad(track.angle_deg[chosen]), (float(pivot[0]), float(pivot[1])), lines
        )
        evidence = evidence_of(
            scene,
            np.deg2rad(track.angle_deg[tried]),
            np.deg2rad(track.sigma_deg[tried]),
            track.found[tried],
            rolls,
            entering(np.stack(pictures))
            if entering is not None
            else elsewhere(options, film, scene.usual.shape),
        )
        why = contradiction(evidence, options.pointed)
    if why is None:
        return
    x, y = track.pivot_px
    seen = SeenPart(track.pivot_px, track.outline_px)
    raise TrackRefused(
        f"{film.path}: the frames do not confirm the motion found about the pivot "
        f"{x:.0f},{y:.0f}: {why}; expected a part that turns in full view, {POINT}.",
        draw or partial(refusal_picture, film.images, [seen]),
        found=True,
    )


def elsewhere(options: TrackOptions, film: Film, shape: tuple[int, ...]) -> Mask | None:
    """Where the part that was tracked before passes, in pictures of this shape (height, width)."""
    if options.beside is None:
        return None
    mask = swept(options.beside, film.images[0].shape).astype(np.uint8)
    small = cv2.resize(mask, (shape[1], shape[0]), interpolation=cv2.INTER_AREA)
    return np.asarray(small > 0)
