"""What must be in order before a run: each a line, with one sentence on how to correct it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from servosight.bench.camera import CapturedFrame, OpenCamera
from servosight.bench.host_clock import HOST, Clock
from servosight.bench.servo import Reading, SupervisedServo
from servosight.bench.session._lines import Line, line_of
from servosight.bench.session._pictures import picture_of, some_frames
from servosight.bench.timing import MEANINGS, even_stamps, lost_between
from servosight.models.core import Array, Image, InputError

_PICTURES = 12
_FRAMES = 120


@dataclass(frozen=True, kw_only=True)
class CheckLimits:
    """Where a check fails; shares from 0 to 1, grey levels from 0 to 255.

    ``overexposed`` is the largest share of pixels at white, ``dark`` and ``bright`` the range of
    the mean brightness, ``edge`` the least gradient of the sharpest twentieth of the pixels in grey
    levels a pixel, ``unsteady`` the largest change of brightness from frame to frame as a share,
    ``rate_hz`` the least frame rate, ``lost`` the largest share of lost frames, ``jitter`` that of
    the stamps' jitter in a frame time, ``exposure`` that of the exposure in it.
    """

    overexposed: float = 0.02
    dark: float = 25.0
    bright: float = 225.0
    edge: float = 6.0
    unsteady: float = 0.03
    rate_hz: float = 24.0
    lost: float = 0.02
    jitter: float = 0.25
    exposure: float = 0.5


LIMITS = CheckLimits()


@dataclass(frozen=True, kw_only=True)
class MeasuredRate:
    """Frames as they really come: rate by the camera's clock, lost ones, jitter of the stamps."""

    rate_hz: float
    frames: int
    lost: int
    jitter_s: float
    meaning: str


def measure_camera(camera: OpenCamera, frames: int = _FRAMES) -> MeasuredRate:
    """Measure rate and jitter over some frames; InputError where fewer than ten come."""
    return _rate(camera, some_frames(camera, frames, HOST))


def check_camera(
    camera: OpenCamera, limits: CheckLimits = LIMITS, *, frames: int = _FRAMES, clock: Clock = HOST
) -> list[Line]:
    """Look through a camera for a second or two; time passes by ``clock``."""
    taken = some_frames(camera, frames, clock)
    images = [picture_of(one, camera.stream) for one in taken[:: max(frames // _PICTURES, 1)]]
    rate = _rate(camera, taken)
    return [*judge_rate(rate, camera.stream.exposure_s, limits), *judge_pictures(images, limits)]


def judge_rate(
    rate: MeasuredRate, exposure_s: float | None, limits: CheckLimits = LIMITS
) -> list[Line]:
    """Frame rate, lost frames, jitter and exposure time."""
    frame_s = 1.0 / rate.rate_hz
    share = rate.lost / (rate.frames + rate.lost)
    lines = [
        line_of(
            "frame rate",
            rate.rate_hz >= limits.rate_hz,
            f"{rate.rate_hz:.2f} frames/s",
            f"expected {limits.rate_hz:g} or more: choose a faster mode, or more light, since a "
            "camera in the dark lowers its rate",
        ),
        line_of(
            "lost frames",
            share <= limits.lost,
            f"{rate.lost} of {rate.frames + rate.lost}",
            "use a port of its own for the camera, MJPEG, or a smaller picture",
        ),
        line_of(
            "time stamps",
            rate.jitter_s <= limits.jitter * frame_s,
            f"{rate.meaning}; jitter {1e3 * rate.jitter_s:.2f} ms",
            "frames come unevenly: fix the exposure, and end other programs that use the camera",
        ),
    ]
    if exposure_s is None:
        words = "not known; estimated from the coded light"
        lines.append(Line(what="exposure", good=True, words=words))
    else:
        lines.append(
            line_of(
                "exposure",
                exposure_s <= limits.exposure * frame_s,
                f"{1e3 * exposure_s:.2f} ms",
                f"expected at most {1e3 * limits.exposure * frame_s:.1f} ms: shorten it and add "
                "light",
            )
        )
    return lines


def judge_pictures(images: Sequence[Image], limits: CheckLimits = LIMITS) -> list[Line]:
    """Brightness, sharpness and steadiness of pictures (height, width) of a scene at rest."""
    first = images[len(images) // 2]
    white = float((first >= 250).mean())
    means = np.array([float(image.mean()) for image in images])
    mean = float(means.mean())
    slope = np.hypot(*np.gradient(_smooth(first)))
    edge = float(np.percentile(slope, 95.0))
    unsteady = float(np.ptp(means)) / max(mean, 1.0)
    return [
        line_of(
            "light",
            limits.dark <= mean <= limits.bright,
            f"mean brightness {mean:.0f} of 255",
            f"expected {limits.dark:g} to {limits.bright:g}: more light, or another gain",
        ),
        line_of(
            "overexposure",
            white <= limits.overexposed,
            f"{100.0 * white:.1f} % of the picture is white",
            f"expected at most {100.0 * limits.overexposed:g} %: shorten the exposure, lower the "
            "gain",
        ),
        line_of(
            "sharpness",
            edge >= limits.edge,
            f"edges of {edge:.1f} grey levels a pixel",
            f"expected {limits.edge:g} or more: focus on the surface and fix the focus; a plain "
            "surface needs a printed pattern",
        ),
        line_of(
            "steadiness",
            unsteady <= limits.unsteady,
            f"brightness changes by {100.0 * unsteady:.1f} %",
            f"expected at most {100.0 * limits.unsteady:g} %: switch automatic exposure and gain "
            "off, use a lamp without flicker, and let nothing move",
        ),
    ]


def check_servo(servo: SupervisedServo) -> list[Line]:
    """Ask a servo what it measures; nothing moves."""
    limits = servo.limits
    lines = [
        Line(what="limits", good=True, words=f"{limits.low_deg:g} to {limits.high_deg:g} deg"),
    ]
    try:
        reading = servo.read()
    except InputError as error:
        return [*lines, Line(what="servo", good=False, words=str(error))]
    lines.insert(0, Line(what="servo", good=True, words=f"{servo.name}: {reading_words(reading)}"))
    if reading.angle_deg is not None:
        lines.append(
            line_of(
                "position",
                limits.low_deg <= reading.angle_deg <= limits.high_deg,
                f"stands at {reading.angle_deg:.1f} deg",
                "turn it into its limits by hand, or widen --low and --high",
            )
        )
    return lines


def reading_words(reading: Reading) -> str:
    """What a servo measures, in words.

    >>> reading_words(Reading(time_s=0.0, angle_deg=1.25, voltage_v=5.0))
    'stands at 1.25 deg, 5 V'
    """
    parts = [
        f"stands at {reading.angle_deg:.4g} deg" if reading.angle_deg is not None else None,
        f"{reading.current_a:.3g} A" if reading.current_a is not None else None,
        f"{reading.voltage_v:.3g} V" if reading.voltage_v is not None else None,
        f"{reading.temperature_c:.3g} C" if reading.temperature_c is not None else None,
    ]
    return ", ".join(part for part in parts if part) or "answers, and measures nothing of itself"


def serial_ports(devices: Path = Path("/dev")) -> list[str]:
    """The serial ports of this computer, by the names that stay the same where there are such."""
    lasting = sorted(str(port) for port in (devices / "serial" / "by-id").glob("*"))
    plain = [str(port) for kind in ("ttyUSB*", "ttyACM*") for port in sorted(devices.glob(kind))]
    return lasting or plain


def _rate(camera: OpenCamera, frames: Sequence[CapturedFrame]) -> MeasuredRate:
    # The first one may have waited since the stream was opened.
    stamps = np.array([frame.stamp_s for frame in frames[1:]])
    number = np.array([float(frame.number) for frame in frames[1:]])
    seconds = max(float(stamps[-1] - stamps[0]), 1e-9)
    return MeasuredRate(
        rate_hz=float(number[-1] - number[0]) / seconds,
        frames=len(number),
        lost=lost_between(number),
        jitter_s=float(np.std(stamps - even_stamps(stamps))) if _even(stamps) else seconds,
        meaning=MEANINGS[camera.stream.meaning],
    )


def _even(stamps: Array) -> bool:
    return bool((np.diff(stamps) > 0.0).all())


def _smooth(image: Image) -> Array:
    """Means over 2 x 2 pixels, so that noise is no edge."""
    rows, columns = (n // 2 * 2 for n in image.shape)
    cut = image[:rows, :columns].astype(np.float64)
    return np.asarray(cut.reshape(rows // 2, 2, columns // 2, 2).mean(axis=(1, 3)))
