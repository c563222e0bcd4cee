"""A checked video, ready to be measured: header, times, and the camera's own motion."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TypeVar

import numpy as np

from servosight.models.core import Array, Image, InputError
from servosight.tracking.core import Shutters, TrackOptions, threaded
from servosight.tracking.video._container import Header, check
from servosight.tracking.video._fields import FieldOrder, most_different, woven_fields
from servosight.tracking.video._frame_table import read_frame_table
from servosight.tracking.video._given import check_interval, check_size, given_shutters
from servosight.tracking.video._prefetch import prefetch
from servosight.tracking.video._rate import even_times
from servosight.tracking.video._remarks import of_clock, of_missing, of_pictures, of_rate
from servosight.tracking.video._stabilisation import LEAST_PX, CameraMotion, Stabiliser
from servosight.tracking.video._video import (
    Frame,
    calm_frames,
    frame_at,
    frames,
    stretches,
)

T = TypeVar("T")

_AHEAD = 8
_RUNS, _RUN_FRAMES, _LARGE_RUN_FRAMES = 8, 40, 20
_LARGE_RUN_BYTES = 200_000_000  # of a run; two are in memory while one follows the other
_KEPT_BYTES = 160_000_000  # of the decoded runs: 98 MB at 640 x 480
_MOUNTED = CameraMotion(0.0, 0.0)


@dataclass(frozen=True)
class Film:
    """A video whose header, times and frame count are checked.

    ``calm`` are some 32 frames spread over it in which little moves, 16 of large pictures, the
    first one first.
    ``table`` is the frames.csv used in place of the file's own times, ``table_time_s`` (frames,)
    its mid-exposure times. ``shutters`` are the given ones, None where nothing is given.
    ``stabiliser`` aligns frames with the first one, None where the camera does not move, as
    ``camera`` says. ``woven`` is the order of the fields of which its pictures are woven although
    the file does not say so, None where they are not. ``kept`` are the decoded ``runs``, none where
    they are too large.
    """

    path: Path
    header: Header
    calm: tuple[Frame, ...]
    table: Path | None = None
    table_time_s: Array | None = None
    shutters: Shutters | None = None
    stabiliser: Stabiliser | None = None
    camera: CameraMotion = _MOUNTED
    woven: FieldOrder | None = None
    kept: tuple[list[Frame], ...] = field(default=(), repr=False, compare=False)

    @property
    def run_frames(self) -> int:
        """The number of frames in a whole run: fewer of large pictures."""
        return _run_frames(self.header)

    @property
    def predicted(self) -> bool:
        """Whether the codec predicts pictures from earlier ones, and so may only copy them."""
        return self.header.predicting is not None

    @property
    def tag_deg(self) -> int:
        """By how much a tag of the file turns its pictures counter-clockwise [deg]."""
        return self.calm[0].tag_deg

    @property
    def sideways(self) -> bool:
        """Whether the rows of the camera's sensor are the pictures' columns."""
        return self.tag_deg % 180 != 0

    @property
    def images(self) -> list[Image]:
        """The calm frames' pictures."""
        return [frame.image for frame in self.calm]

    @cached_property
    def stabilised(self) -> Film:
        """The same video with every frame aligned with the first one, where the camera moves."""
        first, *others = self.images
        bench = Stabiliser.of(first)
        camera = CameraMotion.of(bench, others)
        if bench is not None and camera.rms_px > LEAST_PX:
            bench = bench.steady_in(others)
            camera = replace(camera, rms_px=CameraMotion.of(bench, others).rms_px)
        moves = camera.rms_px > LEAST_PX
        film = replace(self, stabiliser=bench if moves else None, camera=camera)
        return replace(film, calm=tuple(film._still(frame) for frame in self.calm))

    def exposed(self, shutters: Shutters | None) -> Film:
        """The same video with exposure and readout known; it is not aligned anew."""
        film = replace(self, shutters=shutters)
        if "stabilised" in vars(self):
            vars(film)["stabilised"] = replace(self.stabilised, shutters=shutters)
        return film

    def frames(self) -> Iterator[Frame]:
        """All frames in order; memory does not grow with the video's length."""
        return prefetch(map(self._still, frames(self.path, woven=self.woven)), _AHEAD)

    def decoded(self, coloured: bool = False) -> Iterator[Frame]:
        """The same as they were filmed, with their colour where ``coloured``."""
        return prefetch(frames(self.path, coloured, self.woven), _AHEAD)

    def in_first(self, options: TrackOptions) -> TrackOptions:
        """The options with what points at another frame given in the first one's pixels, where the
        camera has moved between the two."""
        if self.stabiliser is None or options.at_s is None:
            return options
        motion = self.stabiliser.motion(frame_at(self.path, options.at_s, self.woven).image)
        if motion is None:
            return options
        back = motion.before
        pivot, tip, box = options.pivot, options.tip, options.template
        if box is not None:
            x, y, width, height = box
            across = np.array([0.5 * width, 0.5 * height])
            low = back((x + across[0], y + across[1])) - across
            room = np.array(self.images[0].shape[1::-1]) - (width, height)
            x, y = (int(v) for v in np.clip(np.round(low), 0, room))
            box = (x, y, width, height)
        return replace(
            options,
            pivot=None if pivot is None else tuple(back(pivot).tolist()),
            tip=None if tip is None else tuple(back(tip).tolist()),
            template=box,
        )

    def frame_at(self, at_s: float) -> Frame:
        """The frame whose presentation time is nearest to ``at_s``; InputError beyond the end."""
        return self._still(frame_at(self.path, at_s, self.woven))

    def of_runs(self, function: Callable[[list[Frame]], T]) -> Iterator[T]:
        """The function of eight runs of ``run_frames`` neighbouring frames, spread evenly over the
        video, in order.

        They are asked for several times, and decoded once where they fit into ``_KEPT_BYTES``: the
        function then works in threads.
        """
        if self.kept:
            yield from threaded(function, self._kept_still)
            return
        for run in stretches(self.path, _RUNS, self.run_frames, self.woven):
            yield function([self._still(frame) for frame in run])

    @cached_property
    def _kept_still(self) -> list[list[Frame]]:
        return [threaded(self._still, run) for run in self.kept]

    def times(self, stamps_s: Sequence[float], middle_s: float) -> Array:
        """Mid-exposure times [s] (frames,) of frames with these presentation times.

        ``middle_s`` is the time from a frame's start to the middle of its middle row.
        """
        if self.table_time_s is not None:
            _check_length(self.table, len(self.table_time_s), self.path, len(stamps_s))
            return self.table_time_s
        return even_times(np.array(stamps_s), self.header.tick_s) + middle_s

    def notes(self, stamps_s: Sequence[float], missing: Sequence[int] = ()) -> tuple[str, ...]:
        """Remarks on times, codec and camera motion, a sentence each; ``missing`` (frames,) is how
        many pictures before each frame could not be used."""
        notes = of_pictures(self.header, self.tag_deg, self.images[0].shape, self.woven)
        if self.table is None:
            notes += of_clock(self.header, stamps_s[0])
        notes += [*of_rate(self.header, stamps_s), *self.lost(stamps_s, missing)]
        if self.camera.rms_px > LEAST_PX:
            notes.append(
                f"the camera moved by {self.camera.rms_px:.2g} px rms: its motion is measured "
                "on the background and removed, which costs accuracy; mount the camera firmly to "
                "avoid it"
            )
        return tuple(notes)

    def lost(self, stamps_s: Sequence[float], missing: Sequence[int] = ()) -> tuple[str, ...]:
        """Those of the remarks that say which pictures of the file are missing."""
        return tuple(of_missing(self.header, stamps_s, sum(missing)))

    def _still(self, frame: Frame) -> Frame:
        if self.stabiliser is None:
            return frame
        still = self.stabiliser.aligned(frame.image)
        return replace(frame, image=still.image, sigma_px=still.sigma_px, roll_rad=still.roll_rad)


def open_film(video: Path, options: TrackOptions) -> Film:
    """Check a video and what is given of its times; InputError where either cannot be used."""
    table = options.frame_table
    times = read_frame_table(table) if table is not None else None
    header = check(video)
    if table is None and not header.timed and header.declared_hz is None:
        raise InputError(
            f"{video}: holds neither times nor a frame rate, as a raw stream; expected one of "
            "them, put the stream into a container with its rate, or give the times in a "
            "frames.csv."
        )
    if times is not None:
        _check_length(table, len(times[0]), video, header.count)
    kept: list[list[Frame]] = []
    pairs: list[tuple[Image, Image]] = []
    runs = stretches(video, _RUNS, _run_frames(header))
    calm = tuple(calm_frames(_keeping(_moving(runs, pairs), kept)))
    woven = None if header.interlaced or calm[0].tag_deg % 180 else woven_fields(pairs)
    if woven is not None:
        kept = []
        runs = stretches(video, _RUNS, _run_frames(header), woven)
        calm = tuple(calm_frames(_keeping(runs, kept)))
    if options.camera is not None:
        check_size(video, options.camera, calm[0].image.shape)
    shutters = given_shutters(
        video, options, times[1] if times is not None else None, calm[0].tag_deg
    )
    if shutters is not None:
        every_s = header.step_s if times is None else float(np.median(np.diff(times[0])))
        check_interval(table or video, float(np.median(shutters.exposures_s)), every_s)
    return Film(
        video,
        header,
        calm,
        table,
        times[0] if times is not None else None,
        shutters,
        woven=woven,
        kept=tuple(kept),
    )


def _run_frames(header: Header) -> int:
    small = _RUN_FRAMES * header.pixels <= _LARGE_RUN_BYTES
    return _RUN_FRAMES if small else _LARGE_RUN_FRAMES


def _moving(runs: Iterable[list[Frame]], pairs: list[tuple[Image, Image]]) -> Iterator[list[Frame]]:
    """The same runs; ``pairs`` holds of each the neighbouring pictures between which most moves."""
    for run in runs:
        pair = most_different([frame.image for frame in run])
        pairs += [] if pair is None else [pair]
        yield run


def _keeping(runs: Iterable[list[Frame]], kept: list[list[Frame]]) -> Iterator[list[Frame]]:
    """The same runs; ``kept`` holds all of them at the end, or none where they are too large."""
    small = True
    for run in runs:
        small &= sum(frame.image.nbytes for frame in run) * _RUNS <= _KEPT_BYTES
        if small:
            kept.append(run)
        else:
            kept.clear()
        yield run


def _check_length(table: Path | None, rows: int, video: Path, count: int) -> None:
    if rows != count:
        raise InputError(
            f"{table}: lists {rows} frames and {video.name} has {count}; expected one row a "
            "frame, correct or remove the table."
        )
