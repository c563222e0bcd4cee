"""The video's frame where the model fails worst, with the predicted surfaces drawn on it."""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from servosight.app.report.section import Section
from servosight.app.report.story import Story
from servosight.models.core import Array, Image
from servosight.sources import Geometry, geometry_of

if TYPE_CHECKING:
    from servosight.tracking.core import Box

TRUSTED = 4.0
"""A frame may be shown where its sigma is within this factor of the usual one."""
ZOOM_SHARE = 7.0
"""The zoom is as many times as wide as the distance that it shows."""
LEAST_ZOOM_PX = 36
WIDEST_PX = 1280


@dataclass(frozen=True)
class Drawn:
    """An outline to draw: ``kind`` is measured, before or after."""

    kind: str
    name: str
    angle_deg: float
    outline_px: Array

    @property
    def points(self) -> str:
        """The outline as an SVG polygon's points."""
        return " ".join(f"{x:.2f},{y:.2f}" for x, y in self.outline_px)


def section(story: Story) -> Section | None:
    """None where no recording has a video whose surface is known."""
    found = worst_frame(story)
    if found is None:
        return None
    number, index, geometry = found
    recording = story.before.judged[number].recording
    assert recording.video is not None
    from servosight.tracking.core import turned
    from servosight.tracking.video import read_frame

    frame = geometry.frame_of(index)
    image = read_frame(recording.video, frame)
    kinds = ("before", "after")
    angles = [("measured", "measured", float(recording.angle_deg[index]))]
    for kind, model in zip(kinds, story.models, strict=False):
        angles.append((kind, model.name, float(model.judged[number].predicted_deg[index])))
    outline = geometry.outline_px
    outlines = [
        Drawn(kind, name, angle, turned(outline, geometry.pivot_px, np.deg2rad(angle)))
        for kind, name, angle in angles
    ]
    height, width = image.shape
    zoom, apart = _zoom(outlines, (height, width))
    return Section(
        "picture",
        "Seen by the camera",
        {
            "recording": recording.name,
            "frame": frame,
            "time_s": float(recording.time_s[index]),
            "measured": outlines[0],
            "models": outlines[1:],
            "apart_px": apart,
            "whole": _view(image, (0, 0, width, height), "jpeg"),
            "zoom": _view(image, zoom, "png"),
            "zoom_box": zoom,
            "factor": width / zoom[2],
        },
    )


def worst_frame(story: Story) -> tuple[int, int, Geometry] | None:
    """Recording, row and geometry of the largest error among trusted frames."""
    best: tuple[float, int, int, Geometry] | None = None
    for number, one in enumerate(story.before.judged):
        geometry = geometry_of(one.recording)
        if geometry is None:
            continue
        error = np.abs(one.error_deg)
        sigma = one.recording.sigma_deg
        if sigma is not None:
            error = np.where(sigma <= TRUSTED * np.median(sigma), error, 0.0)
        index = int(np.argmax(error))
        if best is None or error[index] > best[0]:
            best = (float(error[index]), number, index, geometry)
    return None if best is None else best[1:]


def _zoom(outlines: list[Drawn], shape: tuple[int, int]) -> tuple[Box, float]:
    """The box (x, y, width, height) about the point furthest off, and how far that is [px]."""
    height, width = shape
    measured, predicted = outlines[0].outline_px, outlines[1].outline_px
    inside = np.all((measured >= 0) & (measured < (width, height)), axis=1)
    distance = np.where(inside, np.hypot(*(measured - predicted).T), 0.0)
    place = int(np.argmax(distance))
    apart = float(distance[place])
    wide = int(np.clip(ZOOM_SHARE * apart, min(LEAST_ZOOM_PX, width), max(width // 2, 1)))
    tall = min(round(0.75 * wide), height)
    x, y = 0.5 * (measured[place] + predicted[place])
    left = int(np.clip(round(x - 0.5 * wide), 0, width - wide))
    top = int(np.clip(round(y - 0.5 * tall), 0, height - tall))
    return (left, top, wide, tall), apart


def _view(image: Image, box: Box, kind: str) -> dict[str, object]:
    """A part of the picture as a data address (``kind`` png or jpeg), and the view that shows it.

    Pixels have integer centres, so a box begins half a pixel before its first.
    """
    from PIL import Image as Picture

    x, y, width, height = box
    picture = Picture.fromarray(image[y : y + height, x : x + width])
    if width > WIDEST_PX:
        picture = picture.resize((WIDEST_PX, round(height * WIDEST_PX / width)))
    stream = io.BytesIO()
    picture.save(stream, format=kind, quality=88)
    data = base64.b64encode(stream.getvalue()).decode("ascii")
    return {
        "x": x - 0.5,
        "y": y - 0.5,
        "width": width,
        "height": height,
        "href": f"data:image/{kind};base64,{data}",
    }
