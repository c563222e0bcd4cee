"""Each line of a check, on either side of its limit."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from support.wires import rig

from servosight.bench.camera import Given, open_camera
from servosight.bench.session import (
    MeasuredRate,
    check_camera,
    check_servo,
    judge_pictures,
    judge_rate,
    serial_ports,
)
from servosight.bench.wire import MjpegServer, ServedFrame
from servosight.models.core import Image, InputError

pytestmark = pytest.mark.pty

GOOD = MeasuredRate(rate_hz=60.0, frames=60, lost=0, jitter_s=1e-4, meaning="the start")


def picture(mean: float = 110.0, contrast: float = 60.0, blur: int = 1) -> Image:
    """A printed pattern of squares."""
    pattern = np.kron(np.random.default_rng(1).integers(0, 2, (12, 16)), np.ones((10, 10)))
    image = mean + contrast * (2.0 * pattern - 1.0)
    return cv2.blur(np.clip(image, 0, 255).astype(np.uint8), (blur, blur))


def bad(lines: list[object]) -> list[str]:
    """What is not in order."""
    return [line.what for line in lines if not line.good]  # type: ignore[attr-defined]


def test_a_good_camera_passes() -> None:
    assert bad(judge_rate(GOOD, 0.004)) == []
    assert bad(judge_rate(GOOD, None)) == []
    assert bad(judge_pictures([picture(), picture()])) == []


@pytest.mark.parametrize(
    ("change", "exposure_s", "what"),
    [
        ({"rate_hz": 20.0}, 0.004, "frame rate"),
        ({"lost": 3}, 0.004, "lost frames"),
        ({"jitter_s": 0.005}, 0.004, "time stamps"),
        ({}, 0.012, "exposure"),
    ],
)
def test_each_line_of_the_rate_has_its_limit(
    change: dict[str, float], exposure_s: float, what: str
) -> None:
    rate = replace(GOOD, **change)  # type: ignore[arg-type]
    assert bad(judge_rate(rate, exposure_s)) == [what]


@pytest.mark.parametrize(
    ("images", "what"),
    [
        ([picture(mean=15.0, contrast=14.0)] * 2, "light"),
        ([picture(mean=200.0, contrast=90.0)] * 2, "overexposure"),
        ([picture(blur=41)] * 2, "sharpness"),
        ([picture(), picture(mean=120.0)], "steadiness"),
    ],
)
def test_each_line_of_the_picture_has_its_limit(images: list[Image], what: str) -> None:
    assert bad(judge_pictures(images)) == [what]


def test_a_camera_on_the_wire_is_checked() -> None:
    data = cv2.imencode(".jpg", picture())[1].tobytes()
    frames = [ServedFrame(number=n, stamp_s=n / 60.0, data=data) for n in range(140)]
    with MjpegServer(lambda: iter(frames)) as server:
        camera = open_camera(server.address, Given(exposure_s=0.004))
        lines = check_camera(camera)
        camera.close()
    assert bad(lines) == []
    assert "60.00 frames/s" in lines[0].words


def test_a_damaged_picture_is_refused() -> None:
    data = cv2.imencode(".jpg", picture())[1].tobytes()
    frames = [ServedFrame(number=n, stamp_s=n / 60.0, data=data[:900]) for n in range(140)]
    with MjpegServer(lambda: iter(frames)) as server:
        camera = open_camera(server.address, Given(exposure_s=0.004))
        with pytest.raises(InputError, match="damaged JPEG"):
            check_camera(camera)
        camera.close()


def test_a_servo_is_checked_without_moving() -> None:
    with rig("dynamixel") as on:
        assert bad(check_servo(on.servo)) == []
        assert not on.far.received
        on.far.angle_deg = 80.0
        assert bad(check_servo(on.servo)) == ["position"]
        on.wire.close()
        assert bad(check_servo(on.servo)) == ["servo"]


def test_ports_have_names_that_last(tmp_path: Path) -> None:
    assert serial_ports(tmp_path) == []
    (tmp_path / "ttyUSB0").touch()
    assert serial_ports(tmp_path) == [str(tmp_path / "ttyUSB0")]
    lasting = tmp_path / "serial" / "by-id"
    lasting.mkdir(parents=True)
    os.symlink("../../ttyUSB0", lasting / "usb-adapter")
    assert serial_ports(tmp_path) == [str(lasting / "usb-adapter")]
