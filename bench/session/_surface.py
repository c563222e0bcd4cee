"""Whether the camera sees the surface: what in the picture moves when the servo turns a little."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from servosight.bench.camera import OpenCamera
from servosight.bench.safety import released
from servosight.bench.servo import SupervisedServo
from servosight.bench.session._lines import Line, line_of
from servosight.bench.session._pictures import picture_of, some_frames
from servosight.models.core import Array, Image

NUDGE_DEG = 5.0
_ROOM_SHARE = 0.5
_REST_S = 0.6
_POLL_S = 0.02
_FRAMES = 4
_BLOCK_PX = 4


@dataclass(frozen=True, kw_only=True)
class SurfaceLimits:
    """Where the look for the surface fails.

    ``change`` is the least change of a block of 4 x 4 pixels in grey levels that counts as motion,
    ``share`` the least share of the picture that moves, ``border`` the largest share of the blocks
    along the picture's border that do.
    """

    change: float = 6.0
    share: float = 0.005
    border: float = 0.01


SURFACE_LIMITS = SurfaceLimits()


def check_surface(servo: SupervisedServo, camera: OpenCamera) -> list[Line]:
    """Turn an idle servo from neutral by up to 5 deg and back, and look at what moves.

    The servo is armed for it, and released whatever happens. InputError where no frames come.
    """
    neutral = servo.limits.neutral_deg
    up, down = servo.limits.high_deg - neutral, neutral - servo.limits.low_deg
    step = min(NUDGE_DEG, _ROOM_SHARE * max(up, down)) * (1.0 if up >= down else -1.0)
    with released(servo):
        goals = (neutral, neutral + step, neutral)
        before, turned, after = (_look(servo, camera, goal) for goal in goals)
    return judge_surface(before, turned, after)


def judge_surface(
    before: Image, turned: Image, after: Image, limits: SurfaceLimits = SURFACE_LIMITS
) -> list[Line]:
    """Pictures (height, width) at neutral, turned, and at neutral again."""
    first, second, third = (_blocks(image) for image in (before, turned, after))
    # What has changed without the servo, a light or a hand, is not its surface.
    moved = np.minimum(np.abs(second - first), np.abs(second - third)) - np.abs(third - first)
    moves = moved > limits.change
    share = float(moves.mean())
    rim = np.concatenate([moves[0], moves[-1], moves[1:-1, 0], moves[1:-1, -1]])
    lines = [
        line_of(
            "surface",
            share >= limits.share,
            f"{100.0 * share:.1f} % of the picture moves with the servo",
            f"expected {100.0 * limits.share:g} % or more: point the camera at the surface, go "
            "nearer, and see that servo, horn and surface are joined",
        )
    ]
    if lines[0].good:
        cut = float(rim.mean())
        lines.append(
            line_of(
                "framing",
                cut <= limits.border,
                "what moves is whole in the picture"
                if cut <= limits.border
                else f"what moves reaches {100.0 * cut:.0f} % of the picture's border",
                "expected none of it: move the camera back, or its view to the middle of what "
                "moves",
            )
        )
    return lines


def _look(servo: SupervisedServo, camera: OpenCamera, goal_deg: float) -> Image:
    """The picture at a goal, after a rest in which the camera's latency passes."""
    clock = servo.clock
    servo.move_to(goal_deg)
    until_s = clock.now() + _REST_S
    while clock.now() < until_s:
        servo.read()  # its watchdog would take a long silence for a fault
        clock.wait(clock.now() + _POLL_S)
    frames = some_frames(camera, _FRAMES, clock, servo.read, least=1)
    return picture_of(frames[-1], camera.stream)


def _blocks(image: Image) -> Array:
    rows, columns = (n // _BLOCK_PX for n in image.shape)
    whole = image[: rows * _BLOCK_PX, : columns * _BLOCK_PX].astype(np.float64)
    return np.asarray(whole.reshape(rows, _BLOCK_PX, columns, _BLOCK_PX).mean(axis=(1, 3)))
