"""The tables of a scenario's camera: read, refused, and carried to the renderer."""

from __future__ import annotations

from pathlib import Path

import pytest

from servosight.models.core import InputError
from servosight.scenarios.scenario import Scenario
from servosight.sim.film._codec import Codec


def load(folder: Path, text: str) -> Scenario:
    path = folder / "scenario.toml"
    path.write_text(text, encoding="utf-8")
    return Scenario.load(path)


def test_tables_reach_the_renderer(tmp_path: Path) -> None:
    scenario = load(
        tmp_path,
        "[lens]\nyaw_deg = 20\n[light]\nflicker = 0.2\n[cover]\nshare = 0.3\n"
        '[shake]\nshift_px = 1.0\n[optics]\ndefocus_px = 2.0\n[codec]\nname = "h264"\n',
    )
    settings = scenario.filming
    assert settings.lens.yaw_deg == 20.0
    assert settings.light.flicker == 0.2
    assert settings.cover.share == 0.3
    assert not settings.shake.still
    assert settings.optics.defocus_px == 2.0
    assert settings.codec == Codec("h264")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[lens]\nyaw = 3", "unknown key lens.yaw, expected one of yaw_deg"),
        ("[lens]\nyaw_deg = 80", "expected -60 to 60 degrees"),
        ("[lens]\nk1 = -30.0", "do not fold the picture"),
        ("[light]\nflicker = 2", "light.flicker is 2.0, expected a share of 0 to 1"),
        ("[cover]\nshare = 1.0", "cover.share is 1.0, expected 0 to 0.7"),
        ("[shake]\nshift_px = -1", "shake.shift_px"),
        ('[codec]\nname = "hevc"', "expected one of magicyuv, ffv1, mjpeg, h264"),
        ("[codec]\nquality = 0", "codec.quality is 0, expected 1 to 100"),
        ('[camera]\nwidth = 321\n[codec]\nname = "h264"', "H.264 wants even sides"),
        ("[camera]\njitter_s = 0.01", "a sixth of what exposure and readout leave"),
        ("[camera]\ndropped = 0.9", "a share of 0 to 0.5"),
        ("[camera]\nwidth = 2", "camera.width is 2, expected 64 to 4096 pixels"),
        ("[optics]\ngain = -1.0", "optics.gain"),
        ("[optics]\nwhite_level = 2.0", "optics.dark_level"),
        ("light = 3", r"write \[light\]"),
    ],
)
def test_what_no_camera_does_gets_one_sentence(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(InputError, match=said) as caught:
        load(tmp_path, text)
    assert "\n" not in str(caught.value)
