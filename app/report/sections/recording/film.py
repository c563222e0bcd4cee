"""The worst seconds of the video in slow motion, with the models drawn over the measured part."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from servosight.app.report.section import Section
from servosight.app.report.sections.recording.picture import worst_frame
from servosight.app.report.story import Story
from servosight.models.core import Array, Image
from servosight.sources import Geometry

BEFORE_S, AFTER_S = 0.6, 0.9
"""What is shown before and after the worst instant."""
MOST_FRAMES = 90
SHOWN_RATE = 15
"""Frames a second of the film: whoever watches can follow each."""
WIDEST_PX = 640
ROOM_PX = 24
"""Space around what moves."""
COLOURS = ((43, 140, 255), (227, 143, 26))
"""Of the models, blue-green-red: the report's colours before and after, lighter for a picture."""
OPACITY = 0.35


@dataclass(frozen=True)
class Shot:
    """Which rows of a recording are shown, and how large: box (x, y, width, height), factor."""

    rows: NDArray[np.int64]
    box: tuple[int, int, int, int]
    factor: float


def section(story: Story) -> Section | None:
    """None where no recording has a video whose surface is known."""
    found = worst_frame(story)
    if found is None:
        return None
    number, index, geometry = found
    recording = story.before.judged[number].recording
    assert recording.video is not None
    time_s = recording.time_s
    seen = np.flatnonzero(
        (time_s >= time_s[index] - BEFORE_S) & (time_s <= time_s[index] + AFTER_S)
    )
    rows = seen[:: -(-seen.size // MOST_FRAMES)]
    predicted = [model.judged[number].predicted_deg for model in story.models]
    pictures = list(_pictures(recording.video, geometry, recording.angle_deg, predicted, rows))
    worst = pictures[int(np.argmin(np.abs(rows - index)))]
    shown_s = rows.size / SHOWN_RATE
    return Section(
        "film",
        "The worst moment in slow motion",
        {
            "recording": recording.name,
            "start_s": float(time_s[rows[0]]),
            "end_s": float(time_s[rows[-1]]),
            "slower": shown_s / max(float(time_s[rows[-1]] - time_s[rows[0]]), 1e-9),
            "models": [model.name for model in story.models],
            "href": _address("video/mp4", encoded(pictures)),
            "poster": _address("image/jpeg", _still(worst)),
        },
    )


def _pictures(
    video: Path,
    geometry: Geometry,
    measured_deg: Array,
    predicted_deg: Sequence[Array],
    rows: NDArray[np.int64],
) -> Iterator[Image]:
    """The rows' frames, cut to what moves, each (height, width, 3) blue-green-red."""
    from servosight.tracking.video import frames

    wanted = {geometry.frame_of(int(row)): int(row) for row in rows}
    shot = None
    for frame in islice(frames(video), max(wanted) + 1):
        row = wanted.get(frame.index)
        if row is None:
            continue
        if shot is None:
            shot = _shot(geometry, [measured_deg, *predicted_deg], rows, frame.image.shape)
        angles = [one[row] for one in predicted_deg]
        yield _drawn(frame.image, geometry, float(measured_deg[row]), angles, shot)


def _shot(
    geometry: Geometry, angles: Sequence[Array], rows: NDArray[np.int64], shape: tuple[int, ...]
) -> Shot:
    """The box around all places of the surface during the rows, within the picture."""
    extremes = [float(pick(one[rows])) for one in angles for pick in (np.min, np.max)]
    points = np.vstack([_outline(geometry, angle) for angle in extremes])
    low = np.maximum(np.floor(points.min(axis=0)).astype(int) - ROOM_PX, 0)
    high = np.minimum(np.ceil(points.max(axis=0)).astype(int) + ROOM_PX, shape[1::-1])
    width, height = np.maximum(high - low, 16)
    factor = min(WIDEST_PX / width, WIDEST_PX / height, 4.0)
    return Shot(rows, (int(low[0]), int(low[1]), int(width), int(height)), factor)


def _outline(geometry: Geometry, angle_deg: float) -> Array:
    from servosight.tracking.core import turned

    return turned(geometry.outline_px, geometry.pivot_px, np.deg2rad(angle_deg))


def _drawn(
    image: Image, geometry: Geometry, measured: float, predicted: Sequence[float], shot: Shot
) -> Image:
    """Each model's surface as a translucent shape, the measured one as a white outline."""
    import cv2

    x, y, width, height = shot.box
    cut = image[y : y + height, x : x + width]
    even = [2 * round(0.5 * size * shot.factor) for size in (cut.shape[1], cut.shape[0])]
    picture = cv2.cvtColor(
        cv2.resize(cut, even, interpolation=cv2.INTER_LINEAR), cv2.COLOR_GRAY2BGR
    )
    scale = np.array(even) / (cut.shape[1], cut.shape[0])

    def places(angle: float) -> NDArray[np.int32]:
        # Pixels have integer centres, before scaling and after.
        points = (_outline(geometry, angle) - (x, y) + 0.5) * scale - 0.5
        return np.round(points * 16.0).astype(np.int32)

    for angle, colour in zip(predicted, COLOURS, strict=False):
        ghost = picture.copy()
        cv2.fillPoly(ghost, [places(angle)], colour, cv2.LINE_AA, 4)
        picture = cv2.addWeighted(ghost, OPACITY, picture, 1.0 - OPACITY, 0.0)
        cv2.polylines(picture, [places(angle)], True, colour, 2, cv2.LINE_AA, 4)
    cv2.polylines(picture, [places(measured)], True, (255, 255, 255), 1, cv2.LINE_AA, 4)
    return np.asarray(picture, dtype=np.uint8)


def _still(picture: Image) -> bytes:
    """A picture as JPEG, which stands there before the film is played."""
    from PIL import Image as Picture

    memory = io.BytesIO()
    Picture.fromarray(picture[..., ::-1]).save(memory, format="jpeg", quality=80)
    return memory.getvalue()


def _address(kind: str, data: bytes) -> str:
    return f"data:{kind};base64,{base64.b64encode(data).decode('ascii')}"


def encoded(pictures: Iterable[Image]) -> bytes:
    """An MP4 file (H.264) of pictures of one even size; the same pictures give the same bytes."""
    import av

    memory = io.BytesIO()
    with av.open(memory, "w", format="mp4") as container:
        stream = container.add_stream("libx264", rate=Fraction(SHOWN_RATE))
        stream.pix_fmt = "yuv420p"
        stream.options = {"crf": "24", "preset": "medium", "threads": "1"}
        for number, picture in enumerate(pictures):
            if not number:
                stream.height, stream.width = picture.shape[:2]
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="bgr24")))
        container.mux(stream.encode())
    return memory.getvalue()
