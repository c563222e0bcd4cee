"""How a scenario's video is taken: the tables beside [camera], read and checked.

The range of each key stands beside it, in the classes of ``sim``; here is what depends on several.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from servosight.models.core import Camera, require, validated
from servosight.sim.camera import folds
from servosight.sim.film import NAMES, SHOWS, VideoSettings
from servosight.sim.scene import Viewport

TABLES = ("optics", "lens", "light", "cover", "shake", "indicator", "codec")
"""Fields of :class:`VideoSettings` that a scenario declares; docs/camera.md lists their keys."""


def read_filming(table: Mapping[str, Any], source: str) -> VideoSettings:
    """Read the tables that are there; InputError names the key that is wrong."""
    return validated({name: table[name] for name in TABLES if name in table}, VideoSettings, source)


def filming_tables(filming: VideoSettings) -> dict[str, dict[str, Any]]:
    """Tables that :func:`read_filming` reads back."""
    return {name: asdict(getattr(filming, name)) for name in TABLES}


def check_camera(camera: Camera, source: str) -> None:
    """Raise InputError for a camera that cannot be."""
    period_s = 1.0 / camera.rate_hz
    idle_s = max(period_s - max(camera.exposure_s, camera.readout_s), 0.0)
    for name in ("exposure_s", "readout_s"):
        value = getattr(camera, name)
        holds = 0.0 <= value <= period_s
        require(holds, source, f"camera.{name}", value, "0 to 1 / rate_hz seconds")
    require(
        0.0 <= 6.0 * camera.jitter_s <= idle_s,
        source,
        "camera.jitter_s",
        camera.jitter_s,
        f"0 to {idle_s / 6.0:.3g} seconds, a sixth of what exposure and readout leave between two "
        f"frames",
    )
    if camera.pivot_px is not None:
        x, y = camera.pivot_px
        holds = 0.0 <= x <= camera.width - 1 and 0.0 <= y <= camera.height - 1
        require(holds, source, "camera.pivot_px", camera.pivot_px, "a place within the picture")


def check_filming(filming: VideoSettings, camera: Camera, source: str) -> None:
    """Raise InputError for what no lens, lamp or codec does."""
    optics, codec, shows = filming.optics, filming.codec, filming.indicator.shows
    even = camera.width % 2 == 0 and camera.height % 2 == 0
    checks: tuple[tuple[bool, str, object, str], ...] = (
        (
            optics.dark_level < optics.white_level,
            "optics.dark_level",
            optics.dark_level,
            "less than white_level",
        ),
        (
            not folds(Viewport.of(camera), filming.lens),
            "lens.k1",
            filming.lens.k1,
            "coefficients that do not fold the picture over itself",
        ),
        (shows in SHOWS, "indicator.shows", shows, f"one of {', '.join(SHOWS)}"),
        (codec.name in NAMES, "codec.name", codec.name, f"one of {', '.join(NAMES)}"),
        (
            codec.name != "h264" or even,
            "codec.name",
            codec.name,
            f"another codec for {camera.width} x {camera.height} px, as H.264 wants even sides",
        ),
    )
    for holds, key, value, expected in checks:
        require(holds, source, key, value, expected)
