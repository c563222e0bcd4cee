"""Film a clip: motion blur, camera, hand, phone's processing, codec; and keep its truth."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np

from servosight.models.core import Array, Image, Single
from wild.drawing import FINER, MARGIN_PX, background, hand, part
from wild.scene import WildScene, angles_rad, parts_of, scene_of

_MOST_PARTS = 24
_GAMMA = 1.0 / 2.2
_GREY = np.array([0.114, 0.587, 0.299], np.float32)  # of blue, green and red: ITU-R BT.601


@dataclass(frozen=True)
class WildTruth:
    """One turning part of a clip.

    Mean angle [deg] of each frame's exposure (frames,), frames after the pan that no hand
    crosses, and what is drawn: its pivot is that in the frames at rest.
    """

    angle_deg: Array
    usable: Array
    part: WildScene

    def at_deg(self, time_s: Array) -> Array:
        """The angle [deg] at times of the video (n,), of which zero is the start of the first
        frame's exposure."""
        return np.rad2deg(angles_rad(self.part, time_s))


def filmed(number: int, folder: Path) -> tuple[Path, tuple[WildTruth, ...]]:
    """The clip of that number and the truth of its parts, composed unless they are there."""
    scene = scene_of(number)
    video, table = folder / f"{number:04d}.mp4", folder / f"{number:04d}.npz"
    if not table.exists():
        folder.mkdir(parents=True, exist_ok=True)
        usable = encode(scene, video)
        at_s = scene.time_s[:, None] + scene.exposure_share / scene.rate_hz * (
            np.linspace(-0.5, 0.5, 9)
        )
        angle = [
            angles_rad(one, at_s.ravel()).reshape(at_s.shape).mean(1) for one in parts_of(scene)
        ]
        np.savez(table, angle_deg=np.rad2deg(angle), usable=usable)
    with np.load(table) as known:
        parts = zip(known["angle_deg"], known["usable"], parts_of(scene), strict=True)
        return video, tuple(WildTruth(angle, usable, one) for angle, usable, one in parts)


def encode(scene: WildScene, video: Path) -> Array:
    """Compose and compress a clip; returns which frames are usable, (parts, frames)."""
    width, height = scene.size
    usable = np.ones((len(parts_of(scene)), scene.frames), bool)
    rate = Fraction(scene.rate_hz).limit_denominator(1000)
    options = {"preset": "veryfast", "threads": "1"}  # with several each run writes another file
    if scene.codec == "libx265":
        alone = "log-level=none:pools=1:frame-threads=1"
        options = {"preset": "ultrafast", "x265-params": alone}
    with av.open(str(video), "w") as container:
        stream = container.add_stream(scene.codec, rate=rate, options=options)
        stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
        stream.bit_rate = int(scene.bits_s)
        for number, (picture, clear) in enumerate(pictures(scene)):
            usable[:, number] = clear
            frame = av.VideoFrame.from_ndarray(picture, format="bgr24")
            container.mux(stream.encode(frame.reformat(format="yuv420p")))
        container.mux(stream.encode())
    return usable


def pictures(scene: WildScene) -> Iterator[tuple[Image, list[bool]]]:
    """Each frame (height, width, 3) as the codec receives it, and for which parts it is usable."""
    rng, colours = _rng(scene), np.random.default_rng([2032, scene.number])
    parts = parts_of(scene)
    bench, sprites, passing = background(scene), [part(one) for one in parts], hand(scene)
    camera = _camera(scene, rng)
    duration = scene.frames / scene.rate_hz
    breath = rng.uniform(0.3, 1.0), rng.uniform(0, 2 * np.pi)
    for number, start_s in enumerate(scene.time_s):
        view = camera[number]
        picture = _behind(bench, view, scene.size)
        if scene.bystander:
            _bystander(picture, scene, start_s / duration)
        for one, sprite in zip(parts, sprites, strict=True):
            _put(picture, *sprite, one, view, *_exposed(one, start_s))
        hidden = _passing(picture, passing, scene, start_s)
        light = 1.0 + scene.breathing * np.sin(2 * np.pi * breath[0] * start_s + breath[1])
        if scene.focus_px:
            sigma_px = scene.focus_px * (0.5 + 0.5 * np.sin(2 * np.pi * breath[0] * start_s))
            picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), 0.05 + sigma_px), np.float32)
        yield (
            _processed(picture * np.float32(light), scene, rng, colours),
            [not (_covered(hidden, one) or start_s < scene.pan_s) for one in parts],
        )


def _exposed(scene: WildScene, middle_s: float) -> tuple[Array, Array]:
    """The part's angles (m,) while the rows of a frame are exposed, as many in an exposure as its
    tip moves by pixels; and the share of each row's exposure at each of them (rows, m)."""
    exposure_s, readout_s = (
        share / scene.rate_hz for share in (scene.exposure_share, scene.readout_share)
    )
    ends = angles_rad(scene, middle_s + exposure_s * np.array([-0.5, 0.5]))
    count = int(np.clip(np.ptp(ends) * scene.length_px, 1, _MOST_PARTS))
    if readout_s == 0.0:
        late_s = exposure_s * ((np.arange(count) + 0.5) / count - 0.5)
        return angles_rad(scene, middle_s + late_s), np.full((scene.size[1], count), 1.0 / count)
    step_s = min(exposure_s / count, readout_s / _MOST_PARTS)
    half = int(np.ceil(0.5 * (exposure_s + readout_s) / step_s))
    late_s = step_s * np.arange(-half, half + 1)
    row_s = readout_s * (np.arange(scene.size[1]) / (scene.size[1] - 1) - 0.5)
    inside = 0.5 + (0.5 * exposure_s - np.abs(late_s - row_s[:, None])) / step_s
    share = np.clip(inside, 0.0, 1.0)
    return angles_rad(scene, middle_s + late_s), share / share.sum(1, keepdims=True)


def views(scene: WildScene) -> Array:
    """The view of each frame: from the scene to the picture, (frames, 3, 3)."""
    return _camera(scene, _rng(scene))


def seen_at(views: Array, place: Array) -> Array:
    """Where the views (n, 3, 3) show a point (2,) of the scene; (n, 2)."""
    seen = views @ np.append(place, 1.0)
    return np.asarray(seen[:, :2] / seen[:, 2:])


def _rng(scene: WildScene) -> np.random.Generator:
    """For the camera's motion, then for the rest of the filming."""
    return np.random.default_rng([2031, scene.number])


def _camera(scene: WildScene, rng: np.random.Generator) -> Array:
    """The view of each frame: from the scene to the picture, (frames, 3, 3)."""
    t = scene.time_s
    views = np.tile(np.eye(3), (scene.frames, 1, 1))
    sway = np.zeros((3, scene.frames))
    for axis in range(3):
        for hz, size in ((0.4, 1.0), (1.3, 0.6), (3.1, 0.35), (7.0, 0.2)):
            sway[axis] += size * np.sin(2 * np.pi * hz * t + rng.uniform(0, 2 * np.pi))
    sway *= scene.shake_px / 0.9
    if scene.stabilised:  # what a phone leaves: a fifth of it, and its own errors frame by frame
        own = np.random.default_rng([2035, scene.number])
        sway = 0.2 * sway + 0.3 * own.standard_normal(sway.shape)
    late = np.clip(1.0 - t / scene.pan_s, 0.0, 1.0) if scene.pan_s else np.zeros_like(t)
    heading = rng.uniform(0, 2 * np.pi)
    away = rng.uniform(60, 180) * (0.5 - 0.5 * np.cos(np.pi * late))
    roll = sway[2] * 6e-4
    zoom = 1.0 + 0.06 * rng.uniform(-1, 1) * late
    for number in range(scene.frames):
        cos, sin = zoom[number] * np.cos(roll[number]), zoom[number] * np.sin(roll[number])
        turn = np.array([[cos, sin], [-sin, cos]])
        centre = 0.5 * np.array(scene.size)
        shift = sway[:2, number] + away[number] * np.array([np.cos(heading), np.sin(heading)])
        views[number, :2] = np.column_stack([turn, centre + shift - turn @ centre])
    return scene.oblique @ views


def _behind(bench: Single, view: Array, size: tuple[int, int]) -> Single:
    shifted = view @ _moved(np.array([-MARGIN_PX, -MARGIN_PX]))
    seen = cv2.warpPerspective(
        bench, shifted, size, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT
    )
    return np.asarray(seen, np.float32)


def _put(
    picture: Single, sprite: Single, middle: tuple[float, float], scene: WildScene, view: Array,
    angles: Array, shares: Array,
) -> None:  # fmt: skip
    """Lay the part over the picture at these angles (m,), which each row shows by their shares
    (rows, m), its shadow first."""
    pivot = seen_at(view[None], np.array(scene.pivot_px))[0]
    reach = int(1.25 * scene.length_px * 1.1 * scene.largest + 14)
    low = np.maximum(np.floor(pivot).astype(int) - reach, 0)
    high = np.minimum(np.floor(pivot).astype(int) + reach, scene.size)
    if (high - low < 8).any():
        return
    total = np.zeros((int(high[1] - low[1]), int(high[0] - low[0]), 4), np.float32)
    for angle, share in zip(angles, shares[low[1] : high[1]].T, strict=True):
        cos, sin = np.cos(angle), np.sin(angle)
        turn = np.array([[cos, sin], [-sin, cos]]) / FINER
        # Pixel centres of the enlarged picture.
        placed = np.eye(3)
        placed[:2, :2] = turn
        placed[:2, 2] = scene.pivot_px - turn @ (np.array(middle) - 0.5 * (FINER - 1))
        matrix = _moved(-low) @ view @ placed
        seen = cv2.warpPerspective(sprite, matrix, total.shape[1::-1], flags=cv2.INTER_LINEAR)
        total += np.asarray(share, np.float32)[:, None, None] * seen
    place = picture[low[1] : high[1], low[0] : high[0]]
    if scene.shadow:
        soft = cv2.GaussianBlur(np.roll(total[:, :, 3], (7, 5), (0, 1)), (0, 0), 4.0)
        place *= 1.0 - scene.shadow * soft[:, :, None]
    place *= 1.0 - total[:, :, 3:]
    place += total[:, :, :3]


def _moved(by_px: Array) -> Array:
    """A shift as a homography (3, 3)."""
    moved = np.eye(3)
    moved[:2, 2] = by_px
    return moved


def _bystander(picture: Single, scene: WildScene, share: float) -> None:
    """Someone who sways at the edge of the picture."""
    width, height = scene.size
    at = (int(width * (0.02 + 0.05 * np.sin(9 * share))), int(0.4 * height))
    cv2.ellipse(
        picture, at, (int(0.09 * width), int(0.5 * height)), 4, 0, 360, (0.3, 0.2, 0.15), -1
    )


def _passing(picture: Single, passing: Single, scene: WildScene, now_s: float) -> Array:
    """Lay the hand over the picture while it passes; x and y of what it hides, (2, pixels)."""
    if scene.hand_s is None:
        return np.empty((2, 0))
    lasting = 0.16 * scene.frames / scene.rate_hz
    share = (now_s - scene.hand_s) / lasting
    if not 0.0 <= share <= 1.0:
        return np.empty((2, 0))
    size = passing.shape[0]
    width, height = scene.size
    at = np.array(
        [(1.6 * share - 0.3) * width - size / 2, height - 0.95 * size * np.sin(np.pi * share)]
    )
    matrix = np.array([[1.0, 0.0, at[0]], [0.0, 1.0, at[1]]])
    laid = cv2.warpAffine(passing, matrix, (width, height), flags=cv2.INTER_LINEAR)
    picture *= 1.0 - laid[:, :, 3:]
    picture += laid[:, :, :3]
    y, x = np.nonzero(laid[:, :, 3] > 0.5)
    return np.array([x, y], np.float64)


def _covered(hidden: Array, scene: WildScene) -> bool:
    """Whether what a hand hides reaches into the circle of a part."""
    away = np.hypot(hidden[0] - scene.pivot_px[0], hidden[1] - scene.pivot_px[1])
    return bool(away.size) and float(away.min()) < 1.2 * scene.length_px


def _noise(scene: WildScene, rng: np.random.Generator, colours: np.random.Generator) -> Single:
    """A sensor's noise, independent in blue, green and red as its pixels are; (height, width, 3).

    Its grey is drawn from ``rng`` alone, so that it is that of clips made without noise of colour.
    """
    size = (scene.size[1], scene.size[0])
    own = cv2.GaussianBlur(colours.standard_normal((*size, 3), np.float32), (0, 0), 0.6)
    own /= np.float32(np.linalg.norm(_GREY))  # so that its grey is as strong as that of ``rng``
    grey = cv2.GaussianBlur(rng.standard_normal(size, np.float32), (0, 0), 0.6)
    own += (grey - own @ _GREY)[:, :, None]
    return np.asarray(1.6 * scene.noise * own, np.float32)


def _processed(
    linear: Single, scene: WildScene, rng: np.random.Generator, colours: np.random.Generator
) -> Image:
    """Tone curve, noise, sharpening, bars and caption; uint8 (height, width, 3)."""
    tone = np.clip(linear, 0.0, 1.0) ** _GAMMA
    tone = tone + 0.12 * (tone * (1 - tone) * (2 * tone - 1)) * 2
    grey = 255.0 * np.asarray(tone, np.float32)
    grey += _noise(scene, rng, colours)
    if scene.sharpening:
        grey += scene.sharpening * (grey - cv2.GaussianBlur(grey, (0, 0), 1.2))
    picture = np.clip(np.round(grey), 0, 255).astype(np.uint8)
    height, width = picture.shape[:2]
    if scene.bars:
        across = 0.09 if width > height else 0.06
        bar = int(across * width)
        picture[:, :bar], picture[:, -bar:] = 0, 0
    if scene.caption:
        cv2.putText(
            picture, "Test run", (int(0.3 * width), int(0.1 * height)),
            cv2.FONT_HERSHEY_DUPLEX, 0.9, (255, 255, 255), 2, cv2.LINE_AA,
        )  # fmt: skip
    return picture
