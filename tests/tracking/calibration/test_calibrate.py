"""Boards drawn through a known lens: what calibration makes of them, by the command line too."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from servosight.app.main import main
from servosight.models.core import Array, Image, InputError
from servosight.tracking.calibration import Board, calibrate, read_camera, read_views
from servosight.tracking.core import Lens, MotionPlane, inverse, like_picture, mapped

WIDTH, HEIGHT = 640, 480
LENS = Lens((780.0, 780.0), (325.0, 236.0), (-0.22, 0.06, 4e-4, -3e-4, 0.0))
COLUMNS, ROWS, SQUARE_MM = 9, 7, 10.0
POSES = [
    (0, 0, 0, 140), (30, 0, 10, 135), (-32, 5, -15, 140), (0, 33, 5, 130), (4, -30, 0, 140),
    (25, 20, 30, 140), (-22, 22, -35, 150), (20, -24, 80, 150),
]  # fmt: skip
"""Tilts about y and x, turn [deg], distance [mm]."""


def view(yaw: float, pitch: float, roll: float, away_mm: float) -> Array:
    """Board (x, y, 1) [mm] about its middle to homogeneous straight pixels (3, 3)."""
    turns = [cv2.Rodrigues(np.deg2rad(v))[0] for v in ([0, yaw, 0], [pitch, 0, 0], [0, 0, roll])]
    turn = turns[0] @ turns[1] @ turns[2]
    middle = np.array([COLUMNS * SQUARE_MM / 2, ROWS * SQUARE_MM / 2, 0.0])
    shift = np.array([0.0, 0.0, away_mm]) - turn @ middle
    return np.asarray(LENS.matrix @ np.column_stack([turn[:, :2], shift]), np.float64)


def draw(board: Board, pose: tuple[float, float, float, float]) -> Image:
    """The board through the lens, at twice the size and averaged, with noise."""
    y, x = (np.indices((2 * HEIGHT, 2 * WIDTH)) + 0.5) / 2 - 0.5
    seen = LENS.straight(np.column_stack([x.ravel(), y.ravel()]))
    mm = mapped(inverse(view(*pose)), seen)
    print_ = board.picture()
    texel = (100.0 * (mm / SQUARE_MM + 1.0) - 0.5).astype(np.float32).reshape(2 * HEIGHT, -1, 2)
    big = cv2.remap(print_, texel, None, cv2.INTER_LINEAR, borderValue=255.0)
    small = cv2.resize(big.astype(np.float32), (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
    soft = cv2.GaussianBlur(small, (0, 0), 0.7) * 0.7 + 30.0
    noise = np.random.default_rng(int(pose[0]) + 99).standard_normal(soft.shape)
    return np.clip(np.round(soft + 2.0 * noise), 0, 255).astype(np.uint8)


@pytest.mark.parametrize("kind", ["checkerboard", "aruco"])
def test_the_command_finds_lens_and_plane(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Truth: the lens drawn with. Bounds: a pixel anywhere in the picture but for a common shift
    (eight views leave that much in its corners), and an angle in the plane within 0.02 deg."""
    board = Board("aruco" if kind == "aruco" else "checkerboard", COLUMNS, ROWS, SQUARE_MM)
    files = []
    for number, pose in enumerate(POSES):
        files.append(tmp_path / f"{number}.png")
        cv2.imwrite(str(files[-1]), draw(board, pose))
    output = tmp_path / "camera.toml"
    words = ["calibrate", *map(str, files), "--board", kind, "--columns", str(COLUMNS)]
    words += ["--rows", str(ROWS), "--square-mm", str(SQUARE_MM), "--plane", str(files[1])]
    assert main([*words, "-o", str(output)]) == 0
    told = capsys.readouterr().out
    assert "px rms" in told
    camera = read_camera(output)
    assert camera.size_px == (WIDTH, HEIGHT)
    assert camera.lens is not None
    assert camera.onto is not None
    assert camera.lens.focal_px == pytest.approx(LENS.focal_px, rel=0.01)
    x, y = np.meshgrid(np.arange(40, 620, 60.0), np.arange(40, 460, 60.0))
    rays = (np.column_stack([x.ravel(), y.ravel()]) - LENS.principal_px) / LENS.focal_px
    bent = LENS.bent(rays * LENS.focal_px + LENS.principal_px)
    lens = camera.lens
    again = (lens.straight(bent) - lens.principal_px) / lens.focal_px
    away = (again - rays) * 780.0
    assert np.abs(away - away.mean(0)).max() < 1.0
    plane = MotionPlane(like_picture(camera.onto, np.array([320.0, 240.0])), lens)
    around = np.deg2rad(np.arange(0.0, 60.0, 5.0))
    mm = np.array([45.0, 35.0]) + 25.0 * np.column_stack([np.cos(around), np.sin(around)])
    hub, tips = (
        plane.of_picture(LENS.bent(mapped(view(*POSES[1]), place)))
        for place in (np.array([[45.0, 35.0]]), mm)
    )
    arm = tips - hub
    angle = np.unwrap(np.arctan2(arm[:, 1], arm[:, 0]))
    error = np.abs(np.rad2deg((angle - angle[0]) * np.sign(angle[-1] - angle[0]) - around))
    assert error.max() < 0.02


def test_a_board_of_another_size_is_refused() -> None:
    board = Board("checkerboard", COLUMNS, ROWS, SQUARE_MM)
    views = {"a.png": draw(board, POSES[0])}
    with pytest.raises(InputError, match="squares, not corners"):
        calibrate(views, Board("checkerboard", 12, 9, SQUARE_MM))


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("nonsense = [", "no TOML"),
        ("format = 1", "neither a table lens nor a table plane"),
        ("[lens]\nfocal_px = [1, 2, 3]", "lens.focal_px is .1, 2, 3., expected 2 numbers"),
        ("[plane]\nonto = [[1, 0, 0], [1, 0, 0], [0, 0, 1]]", "maps the picture to a line"),
        (
            "[plane]\nonto = [[1, -1e308, 0], [0, 1, 0], [0, 0, 1]]",
            "-1e.308.*at most 1e.09",
        ),
        ("width = 0\nheight = 10", "width is 0, expected a whole number of pixels above 0"),
    ],
)
def test_a_wrong_camera_file_is_told_in_one_sentence(tmp_path: Path, text: str, what: str) -> None:
    file = tmp_path / "camera.toml"
    file.write_text(text)
    with pytest.raises(InputError, match=what):
        read_camera(file)


@pytest.mark.parametrize("ending", ["png", "jpg", "bmp", "tif"])
def test_a_damaged_picture_is_one_sentence(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], ending: str
) -> None:
    """Cut in half: no library says anything of its own on the terminal."""
    rng = np.random.default_rng(2)
    picture = rng.integers(0, 255, (120, 160), dtype=np.uint8)
    file = tmp_path / f"view.{ending}"
    whole = cv2.imencode(f".{ending}", picture)[1].tobytes()
    file.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(InputError, match="cannot be read as a picture"):
        read_views([file])
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
def test_a_picture_is_read_as_it_is(tmp_path: Path, depth: type) -> None:
    rng = np.random.default_rng(2)
    picture = rng.integers(0, 255, (40, 50), dtype=np.uint8)
    file = tmp_path / "view.png"
    scale = 1 if depth is np.uint8 else 257
    file.write_bytes(cv2.imencode(".png", picture.astype(depth) * depth(scale))[1].tobytes())
    assert np.array_equal(read_views([file])[str(file)], picture)
