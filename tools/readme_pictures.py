"""The README's two pictures at the top, from the folder of a demo, as its report draws them.

    servosight demo -o out/demo31 --seed 31
    python tools/readme_pictures.py out/demo31

writes docs/pictures/overlay.png and worst-moment.png. Seed 31 hides a flexible shaft.
"""

from __future__ import annotations

import base64
import io
import itertools
import sys
from pathlib import Path
from typing import Any

from PIL import Image, ImageDraw

import servosight as ss
from servosight.app.report.figure import png
from servosight.app.report.sections.recording import angle, picture
from servosight.app.report.story import Story
from servosight.models.effects import catalogue

PICTURES = Path(__file__).resolve().parent.parent / "docs" / "pictures"
SHARPER = 4
"""Outlines are drawn so many times larger, and averaged."""
STROKES = {"measured": ("#ffffff", 5), "before": ("#ff8c2b", 2), "after": ("#1a8fe3", 2)}
CASING = (0, 0, 0, 128)
DASHES = (6.0, 4.0)
"""Colours, widths and dashes [px] as of ``.photo`` in app/report/templates/style.css."""


def main() -> None:
    """Write both."""
    folder = Path(sys.argv[1])
    recording = ss.read(folder / "recording")
    found: Any = ss.load(folder / "diagnosis.json")
    story = Story.of(found, [recording], catalogue())
    close = png((8.2, 4.4), 98.0, angle.worst_moment(story))
    (PICTURES / "worst-moment.png").write_bytes(reduced(Image.open(io.BytesIO(close))))
    shown = picture.section(story)
    if shown is None:
        sys.exit(f"{folder}: the recording has no video with a track")
    (PICTURES / "overlay.png").write_bytes(reduced(overlay(shown.values)))


def overlay(values: Any) -> Image.Image:
    """The frame where the first model fails worst, with the outlines on it."""
    data = values["whole"]["href"].partition(",")[2]
    frame = Image.open(io.BytesIO(base64.b64decode(data))).convert("RGBA")
    layer = Image.new("RGBA", [SHARPER * side for side in frame.size])
    draw = ImageDraw.Draw(layer)
    outlines = [values["measured"], *values["models"]]
    for one in outlines:
        draw.line(closed(one), CASING, SHARPER * (STROKES[one.kind][1] + 2), joint="curve")
    for one in outlines:
        colour, width = STROKES[one.kind]
        for part in dashed(closed(one)) if one.kind == "before" else [closed(one)]:
            draw.line(part, colour, SHARPER * width, joint="curve")
    return Image.alpha_composite(frame, layer.resize(frame.size, Image.Resampling.BOX))


def closed(one: picture.Drawn) -> list[tuple[float, float]]:
    """The outline on the large layer; pixels have integer centres."""
    points = [(SHARPER * (x + 0.5), SHARPER * (y + 0.5)) for x, y in one.outline_px]
    return [*points, points[0]]


def dashed(points: list[tuple[float, float]]) -> list[list[tuple[float, float]]]:
    """The parts of a line that are drawn, from corner to corner and dash to dash."""
    lengths = [SHARPER * length for length in DASHES]
    parts: list[list[tuple[float, float]]] = [[points[0]]]
    drawn, left = True, lengths[0]
    for (x, y), (to_x, to_y) in itertools.pairwise(points):
        way = ((to_x - x) ** 2 + (to_y - y) ** 2) ** 0.5
        at = 0.0
        while way - at > left:
            at += left
            corner = (x + (to_x - x) * at / way, y + (to_y - y) * at / way)
            if drawn:
                parts[-1].append(corner)
            else:
                parts.append([corner])
            drawn = not drawn
            left = lengths[0 if drawn else 1]
        left -= way - at
        if drawn:
            parts[-1].append((to_x, to_y))
    return parts


def reduced(picture: Image.Image) -> bytes:
    """A PNG file of 256 colours."""
    stream = io.BytesIO()
    picture.convert("RGB").quantize(256).save(stream, format="PNG", optimize=True)
    return stream.getvalue()


if __name__ == "__main__":
    main()
