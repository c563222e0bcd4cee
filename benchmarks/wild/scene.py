"""What a clip shows and how it is filmed, drawn from its number."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from servosight.models.core import Array

KINDS = ("arm", "horn", "flap", "wheel", "needle")
_BESIDE = 1_000_000
"""The second part of a clip is the part of the clip so much further on."""
MOTIONS = ("sine", "sines", "steps", "swing")
_SIZES = ((640, 360), (640, 480), (480, 640), (854, 480))
_RATES_HZ = (24.0, 30.0, 30.0, 50.0, 60.0, 60.0, 120.0, 240.0)
_LEAST_S, _FRAMES = 1.2, 120
_FASTEST_RAD = 0.3  # from frame to frame
_LEANING = 4000  # clips before it were measured with a camera that looks along the axis
_ROLLING = 4300  # from it on each third clip has a rolling shutter


@dataclass(frozen=True, kw_only=True)
class WildScene:
    """A clip of one turning part; lengths in pixels, times in seconds.

    ``turns`` is False where the part keeps still: then the right answer is a refusal. ``shake_px``
    is the rms motion of the hand that films, ``pan_s`` how long the camera is panned at first,
    ``hand_s`` when a hand passes (None: never), ``bystander`` whether something else moves.
    ``stabilised`` is a camera whose pictures are shifted so that its shaking hardly shows, and
    ``focus_px`` the largest radius (one sigma) of the blur of a focus that changes. The camera
    looks ``tilt_rad`` off the axis of rotation, towards ``lean_rad`` in the picture, through a lens
    of ``focal_px``. Exposure and readout, from the first row's to the last one's, are shares of the
    frame time.
    """

    number: int
    size: tuple[int, int]
    rate_hz: float
    frames: int
    kind: str
    motion: str
    turns: bool
    length_px: float
    pivot_px: tuple[float, float]
    amplitude_rad: float
    exposure_share: float
    shake_px: float
    pan_s: float
    hand_s: float | None
    bystander: bool
    shadow: float
    noise: float
    sharpening: float
    breathing: float
    bars: bool
    caption: bool
    codec: str
    bits_s: float
    stabilised: bool
    focus_px: float
    tilt_rad: float = 0.0
    lean_rad: float = 0.0
    focal_px: float = np.inf
    readout_share: float = 0.0

    @property
    def oblique(self) -> Array:
        """From a picture along the axis to the one that is filmed, alike in its middle; (3, 3)."""
        along = np.array([np.cos(self.lean_rad), np.sin(self.lean_rad)])
        middle = 0.5 * np.array(self.size, np.float64)
        tilted = np.eye(3)
        tilted[:2, :2] -= (1.0 - np.cos(self.tilt_rad)) * np.outer(along, along)
        tilted[2, :2] = np.sin(self.tilt_rad) / self.focal_px * along
        moved = np.eye(3)
        moved[:2, 2] = middle
        return np.asarray(moved @ tilted @ np.linalg.inv(moved))

    @property
    def largest(self) -> float:
        """By how much the lens enlarges what is nearest, relative to the picture's middle."""
        near = 0.5 * np.hypot(*self.size) * np.sin(self.tilt_rad) / self.focal_px
        return float((1.0 - min(near, 0.5)) ** -2)

    @property
    def time_s(self) -> Array:
        """Times of mid-exposure of the middle row; (frames,)."""
        late = 0.5 * (self.exposure_share + self.readout_share)
        return np.asarray((np.arange(self.frames) + late) / self.rate_hz)

    @property
    def rng(self) -> np.random.Generator:
        """For what is drawn of this clip."""
        return np.random.default_rng([2027, self.number])


def scene_of(number: int) -> WildScene:
    """The clip of that number; one in ten shows nothing that turns."""
    rng, later = np.random.default_rng([2026, number]), np.random.default_rng([2033, number])
    size = _SIZES[rng.integers(len(_SIZES))]
    rate_hz = float(_RATES_HZ[rng.integers(len(_RATES_HZ))])
    frames = int(max(_FRAMES, _LEAST_S * rate_hz))
    least = min(size)
    length = float(rng.uniform(0.18, 0.36) * least)
    middle = 0.5 * np.array(size, np.float64)
    pivot = middle + rng.uniform(-0.12, 0.12, 2) * size
    held = rng.random() < 0.55
    kind = KINDS[rng.integers(len(KINDS))]
    stands = np.random.default_rng([2036, number])
    leans = number >= _LEANING and stands.random() < 2.0 / 3.0
    rolls = number >= _ROLLING and number % 3 == 0
    widest = {"arm": 2.2, "needle": 1.2, "wheel": 1.5}.get(kind, 0.9)
    duration = frames / rate_hz
    return WildScene(
        number=number,
        size=size,
        rate_hz=rate_hz,
        frames=frames,
        kind=kind,
        motion=MOTIONS[rng.integers(len(MOTIONS))],
        turns=number % 10 != 7,
        length_px=length,
        pivot_px=(float(pivot[0]), float(pivot[1])),
        amplitude_rad=float(np.exp(rng.uniform(np.log(0.12), np.log(widest)))),
        exposure_share=float(rng.uniform(0.05, 0.6)),
        shake_px=float(np.exp(rng.uniform(np.log(0.5), np.log(4.0)))) if held else 0.0,
        pan_s=float(rng.uniform(0.15, 0.3) * duration) if held and rng.random() < 0.35 else 0.0,
        hand_s=float(rng.uniform(0.1, 0.8) * duration) if rng.random() < 0.3 else None,
        bystander=bool(rng.random() < 0.25),
        shadow=float(rng.uniform(0.1, 0.5)) if rng.random() < 0.5 else 0.0,
        noise=float(rng.uniform(0.5, 3.0)),
        sharpening=float(rng.uniform(0.0, 1.0)),
        breathing=float(rng.uniform(0.0, 0.06)),
        bars=bool(rng.random() < 0.15),
        caption=bool(rng.random() < 0.2),
        codec="libx265" if rng.random() < 0.25 else "libx264",
        bits_s=float(np.exp(rng.uniform(np.log(1.0e6), np.log(8.0e6)))),
        stabilised=held and bool(later.random() < 0.3),
        focus_px=float(later.uniform(0.5, 1.5)) if later.random() < 0.2 else 0.0,
        tilt_rad=float(np.deg2rad(stands.uniform(0.0, 25.0))) if leans else 0.0,
        lean_rad=float(stands.uniform(0.0, 2.0 * np.pi)),
        focal_px=float(stands.uniform(0.8, 2.5) * max(size)),
        readout_share=float(np.random.default_rng([2037, number]).uniform(0.2, 0.9)) * rolls,
    )


def parts_of(scene: WildScene) -> tuple[WildScene, ...]:
    """What turns in a clip, one scene each: in one of six clips a second servo, where it has room.

    They share the picture and the camera; pivot, length, kind and motion are their own.
    """
    rng = np.random.default_rng([2034, scene.number])
    if rng.random() >= 1.0 / 6.0:
        return (scene,)
    own = scene_of(scene.number + _BESIDE)
    length = float(rng.uniform(0.16, 0.24) * min(scene.size))
    axis = int(np.argmax(scene.size))
    pivot = np.array(scene.pivot_px)
    away = 1.2 * (scene.length_px + length)
    pivot[axis] += away if pivot[axis] < 0.5 * scene.size[axis] else -away
    if not 0.8 * length < pivot[axis] < scene.size[axis] - 0.8 * length:
        return (scene,)
    beside = replace(
        own,
        size=scene.size,
        rate_hz=scene.rate_hz,
        frames=scene.frames,
        turns=scene.turns,
        length_px=length,
        pivot_px=(float(pivot[0]), float(pivot[1])),
        exposure_share=scene.exposure_share,
        readout_share=scene.readout_share,
        shadow=scene.shadow,
    )
    return scene, beside


def angles_rad(scene: WildScene, time_s: Array) -> Array:
    """The part's angle at times (n,), counter-clockwise; zero throughout where nothing turns."""
    rng = np.random.default_rng([2028, scene.number])
    if not scene.turns:
        return np.zeros_like(time_s)
    duration = scene.frames / scene.rate_hz
    # No faster from frame to frame than a viewer could follow.
    limit_hz = _FASTEST_RAD * scene.rate_hz / (2 * np.pi * scene.amplitude_rad)
    base_hz = min(float(rng.uniform(1.2, 4.0)) / duration * 1.5, limit_hz)
    phase = rng.uniform(0, 2 * np.pi)
    wave = np.sin(2 * np.pi * base_hz * time_s + phase)
    if scene.motion == "sines":
        wave = 0.7 * wave + 0.3 * np.sin(2 * np.pi * 1.7 * base_hz * time_s + 2 * phase)
    elif scene.motion == "steps":
        wave = np.tanh(3.0 * wave) / np.tanh(3.0)
    elif scene.motion == "swing":  # at rest at first, then a swing that grows
        grown = np.clip((time_s - 0.2 * duration) / (0.5 * duration), 0.0, 1.0)
        wave = grown * np.sin(2 * np.pi * base_hz * time_s + phase)
    return np.asarray(scene.amplitude_rad * wave + rng.uniform(-np.pi, np.pi))
