"""How a scenario's video is taken: the tables beside [camera], read and checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, get_type_hints

from servosight.models.core import Camera
from servosight.scenarios.toml_table import read_table, require
from servosight.sim.camera import folds
from servosight.sim.film import NAMES, SHOWS, VideoSettings
from servosight.sim.scene import View

MAX_TILT_DEG = 60.0
MAX_SIDE_PX = 4096
MAX_SHARE = 0.7


TABLES = ("optics", "lens", "light", "cover", "shake", "indicator", "codec")
"""Fields of :class:`VideoSettings` that a scenario declares; docs/camera.md lists their keys."""


def read_filming(table: Mapping[str, Any], source: str) -> VideoSettings:
    """Read the tables that are there; InputError names the key that is wrong."""
    kinds = get_type_hints(VideoSettings)
    read = {name: read_table(kinds[name], table.get(name, {}), source, name) for name in TABLES}
    return VideoSettings(**read)


def filming_tables(filming: VideoSettings) -> dict[str, dict[str, Any]]:
    """Tables that :func:`read_filming` reads back."""
    return {name: asdict(getattr(filming, name)) for name in TABLES}


def check_camera(camera: Camera, source: str) -> None:
    """Raise InputError for a camera that cannot be."""
    period_s = 1.0 / camera.rate_hz if camera.rate_hz > 0.0 else 0.0
    idle_s = period_s - max(camera.exposure_s, camera.readout_s)
    pivot = camera.pivot_px
    checks: list[tuple[bool, str, object, str]] = [
        (1.0 <= camera.rate_hz <= 1e4, "rate_hz", camera.rate_hz, "1 to 10000 Hz"),
        (
            0.0 <= camera.exposure_s <= period_s,
            "exposure_s",
            camera.exposure_s,
            "0 to 1 / rate_hz seconds",
        ),
        (
            0.0 <= camera.readout_s <= period_s,
            "readout_s",
            camera.readout_s,
            "0 to 1 / rate_hz seconds",
        ),
        (
            0.0 <= 6.0 * camera.jitter_s <= idle_s,
            "jitter_s",
            camera.jitter_s,
            f"0 to {max(idle_s, 0.0) / 6.0:.3g} seconds, a sixth of what exposure and readout leave"
            f" between two frames",
        ),
        (0.0 <= camera.dropped <= 0.5, "dropped", camera.dropped, "a share of 0 to 0.5"),
        (camera.clock_seed >= 0, "clock_seed", camera.clock_seed, "a whole number from 0"),
        (64 <= camera.width <= MAX_SIDE_PX, "width", camera.width, f"64 to {MAX_SIDE_PX} pixels"),
        (
            64 <= camera.height <= MAX_SIDE_PX,
            "height",
            camera.height,
            f"64 to {MAX_SIDE_PX} pixels",
        ),
        (
            pivot is None
            or (0.0 <= pivot[0] <= camera.width - 1 and 0.0 <= pivot[1] <= camera.height - 1),
            "pivot_px",
            pivot,
            "a place within the picture",
        ),
    ]
    for holds, key, value, expected in checks:
        require(holds, source, f"camera.{key}", value, expected)


def check_filming(filming: VideoSettings, camera: Camera, source: str) -> None:
    """Raise InputError for what no lens, lamp or codec does."""
    optics, lens, light = filming.optics, filming.lens, filming.light
    cover, shake, codec = filming.cover, filming.shake, filming.codec
    tilt = f"-{MAX_TILT_DEG:g} to {MAX_TILT_DEG:g} degrees"
    checks: list[tuple[bool, str, object, str]] = [
        (
            0.0 <= optics.dark_level < optics.white_level,
            "optics.dark_level",
            optics.dark_level,
            "0 to white_level grey levels",
        ),
        (
            optics.white_level <= 1000.0,
            "optics.white_level",
            optics.white_level,
            "dark_level to 1000 grey levels",
        ),
        *(
            (0.0 <= value <= top, f"optics.{key}", value, f"0 to {top:g} {unit}")
            for key, value, top, unit in (
                ("gain", optics.gain, 10.0, "grey levels an electron"),
                ("read_noise_e", optics.read_noise_e, 1e4, "electrons"),
                ("pixel_gain_rms", optics.pixel_gain_rms, 0.2, "of the signal"),
                ("pixel_offset_rms", optics.pixel_offset_rms, 50.0, "grey levels"),
                ("blur_px", optics.blur_px, 10.0, "pixels"),
                ("defocus_px", optics.defocus_px, 20.0, "pixels"),
                ("vignetting", optics.vignetting, 0.9, "of the light"),
            )
        ),
        (0.2 <= optics.gamma <= 5.0, "optics.gamma", optics.gamma, "0.2 to 5"),
        (abs(lens.yaw_deg) <= MAX_TILT_DEG, "lens.yaw_deg", lens.yaw_deg, tilt),
        (abs(lens.pitch_deg) <= MAX_TILT_DEG, "lens.pitch_deg", lens.pitch_deg, tilt),
        (
            not folds(View.of(camera), lens),
            "lens.k1",
            lens.k1,
            "coefficients that do not fold the picture over itself",
        ),
        (0.0 <= light.ramp <= 10.0, "light.ramp", light.ramp, "0 to 10 times the brightness"),
        (0.0 <= light.flicker <= 1.0, "light.flicker", light.flicker, "a share of 0 to 1"),
        (0.1 <= light.flicker_hz <= 1e5, "light.flicker_hz", light.flicker_hz, "0.1 to 1e5 Hz"),
        (0.0 <= light.shadow <= 1.0, "light.shadow", light.shadow, "a share of 0 to 1"),
        (0.0 <= light.glint <= 100.0, "light.glint", light.glint, "0 to 100 times white"),
        (cover.start_s >= 0.0, "cover.start_s", cover.start_s, "0 or more seconds"),
        (cover.duration_s >= 0.0, "cover.duration_s", cover.duration_s, "0 or more seconds"),
        (0.0 <= cover.share <= MAX_SHARE, "cover.share", cover.share, f"0 to {MAX_SHARE:g}"),
        (0.0 <= shake.shift_px <= 50.0, "shake.shift_px", shake.shift_px, "0 to 50 pixels"),
        (0.0 <= shake.roll_deg <= 10.0, "shake.roll_deg", shake.roll_deg, "0 to 10 degrees"),
        (0.3 < shake.highest_hz <= 100.0, "shake.highest_hz", shake.highest_hz, "0.3 to 100 Hz"),
        (
            filming.indicator.shows in SHOWS,
            "indicator.shows",
            filming.indicator.shows,
            f"one of {', '.join(SHOWS)}",
        ),
        (codec.name in NAMES, "codec.name", codec.name, f"one of {', '.join(NAMES)}"),
        (1 <= codec.quality <= 100, "codec.quality", codec.quality, "1 to 100"),
        (0 <= codec.crf <= 51, "codec.crf", codec.crf, "0 to 51"),
        (
            codec.name != "h264" or (camera.width % 2 == 0 and camera.height % 2 == 0),
            "codec.name",
            codec.name,
            f"another codec for {camera.width} x {camera.height} px, as H.264 wants even sides",
        ),
    ]
    for holds, key, value, expected in checks:
        require(holds, source, key, value, expected)
