"""The pendulum filmed by hand against marks read by other means: the error of the track.

    python benchmarks/pendulum.py

Reads video/ak80_pendulum.mp4 in the folder that SERVOSIGHT_DATA names. A mark is the centroid of
the dark weight at the arm's end, by a threshold of grey, beside two red things behind the arm, a
socket and a clamp, which show the camera's motion. Its angle is that about the centre of the circle
which all marks describe. What is covered or blurred has another area, and is left out.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import av
import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from servosight.models.core import Array, Image
from servosight.tracking.core import Flag, Track
from servosight.tracking.track import track

VIDEO = Path("video") / "ak80_pendulum.mp4"
COLUMNS = slice(285, 992)  # between the dark bars
DARK, RED = 70, 60  # grey levels; by how much red is above green and blue
OPENED = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (31, 31))  # wider than cords and plugs
SAME_S = 1e-3  # of two times of one frame
MOTOR_FROM_CLAMP, FAR_PX = 96 - 186j, 250.0  # the motor is as dark as the weight


@dataclass(frozen=True)
class Kind:
    """A region to look for: its area [px], by which share it may differ, and how long it is."""

    area: float
    differs: float
    least_aspect: float
    most_aspect: float


WEIGHT = Kind(4200, 0.12, 1.0, 1.15)
SOCKET = Kind(2540, 0.04, 1.0, 1.5)
CLAMP = Kind(708, 0.06, 2.5, 4.0)


@dataclass(frozen=True)
class Mark:
    """Centroids [px] of weight, socket and clamp at ``time_s``, as x + iy with y downwards."""

    time_s: float
    weight: complex
    socket: complex
    clamp: complex


def regions(mask: NDArray[np.bool_], kind: Kind) -> list[complex]:
    """The centroids of the connected regions of a kind."""
    _, _, stats, centres = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    found = []
    for (_, _, width, height, area), centre in zip(stats[1:], centres[1:], strict=True):
        aspect = max(width, height) / min(width, height)
        alike = abs(area / kind.area - 1.0) < kind.differs
        if alike and kind.least_aspect <= aspect < kind.most_aspect:
            found.append(complex(*centre))
    return found


def mark_of(time_s: float, picture: Image) -> Mark | None:
    """The mark in a picture (height, width, 3), blue-green-red; None where not all is seen."""
    seen = cv2.GaussianBlur(picture[:, COLUMNS], (0, 0), 1.0).astype(np.int16)
    red = seen[..., 2] - seen[..., :2].max(-1) > RED
    sockets, clamps = regions(red, SOCKET), regions(red, CLAMP)
    if len(sockets) != 1 or len(clamps) != 1:
        return None
    dark = cv2.morphologyEx((seen.max(-1) < DARK).astype(np.uint8), cv2.MORPH_OPEN, OPENED) > 0
    motor = clamps[0] + MOTOR_FROM_CLAMP
    weights = [place for place in regions(dark, WEIGHT) if abs(place - motor) > FAR_PX]
    return Mark(time_s, weights[0], sockets[0], clamps[0]) if len(weights) == 1 else None


def marks_in(video: Path) -> Iterator[Mark]:
    """The marks of all frames in which they are seen."""
    with av.open(str(video)) as container:
        for frame in container.decode(video=0):
            picture: Image = np.asarray(frame.to_ndarray(format="bgr24"), np.uint8)
            mark = mark_of(float(frame.time or 0.0), picture)
            if mark is not None:
                yield mark


def angles_deg(marks: list[Mark]) -> tuple[Array, Array]:
    """The marks' angles [deg], counter-clockwise, and their distances from the circle [px]."""
    weight, socket, clamp = (
        np.array([getattr(mark, name) for mark in marks]) for name in ("weight", "socket", "clamp")
    )
    roll = np.angle(clamp - socket)
    still = (weight - 0.5 * (socket + clamp)) * np.exp(-1j * (roll - np.median(roll)))

    def away_px(circle: Array) -> Array:
        return np.asarray(np.abs(still - complex(circle[0], circle[1])) - circle[2])

    start = [0.0, float(still.imag.mean()), float(np.ptp(still.imag) / 2.0)]
    circle = optimize.least_squares(away_px, start, loss="soft_l1").x
    return -np.degrees(np.angle(still - complex(circle[0], circle[1]))), away_px(circle)


def errors_deg(angle_deg: Array, truth_deg: Array) -> Array:
    """Differences of angles, within half a turn, less their median."""
    turns = np.exp(1j * np.radians(angle_deg - truth_deg))
    error = np.asarray(np.degrees(np.angle(turns / turns.mean())))
    return error - float(np.median(error))


def report(found: Track, marks: list[Mark]) -> str:
    """The error of the track at the marks, in words."""
    seen = found.measured
    # A mark has the file's time, the start of its exposure, and is where the middle of it shows it.
    starts_s = found.time_s - (found.shutters.middle_s if found.shutters is not None else 0.0)
    first, last = starts_s[seen][[0, -1]]
    marks = [mark for mark in marks if first <= mark.time_s <= last]
    # A picture that repeats the one before shows the weight where it was then.
    again_s = starts_s[(found.flags & Flag.DUPLICATE) > 0]
    marks = [mark for mark in marks if np.all(np.abs(again_s - mark.time_s) > SAME_S)]
    truth, away_px = angles_deg(marks)
    angle = np.interp([m.time_s for m in marks], starts_s[seen], found.angle_deg[seen])
    error = errors_deg(angle, truth)
    turn = np.radians(angle)
    waves = np.column_stack([np.ones_like(turn), np.cos(turn), np.sin(turn)])
    left = error - waves @ np.linalg.lstsq(waves, error)[0]
    return (
        f"{int(seen.sum())} of {found.frames} frames measured, {again_s.size} repeated, "
        f"{np.ptp(found.angle_deg):.0f} deg, sigma {np.median(found.sigma_deg):.2f} deg\n"
        f"{len(marks)} marks, {away_px.std():.2f} px "
        f"rms about their circle\nerror {np.sqrt(np.mean(error**2)):.2f} deg rms, at most "
        f"{np.abs(error).max():.2f} deg; {left.std():.2f} deg rms of it do not follow the angle"
    )


def main() -> None:
    """Print the report."""
    if not os.environ.get("SERVOSIGHT_DATA"):
        print("SERVOSIGHT_DATA is not set: the pendulum is left out")
        return
    video = Path(os.environ["SERVOSIGHT_DATA"]) / VIDEO
    if not video.is_file():
        sys.exit(f"{video}: no such file; expected the video, set SERVOSIGHT_DATA to its folder.")
    print(report(track(video), list(marks_in(video))))


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    main()
