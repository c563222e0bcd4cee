"""Measure the surface's angle in a video, or in a recording's video."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from servosight.app.arguments import (
    add_force,
    add_json,
    any_path,
    box,
    number,
    point,
    rank,
    refuse_without,
    whole,
)
from servosight.app.terminal import check_outputs, check_target, console, progress, write_json
from servosight.models.base import Kind
from servosight.tracking.method_names import METHOD_WORDS

if TYPE_CHECKING:
    from rich.console import Console

    from servosight.tracking.core import MarkerFamily, Track

REFUSED = "track_refused.png"
"""The picture of what was found in a video that was not tracked, beside angle.csv."""


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight track``."""
    parser.add_argument("source", metavar="VIDEO|REC", type=any_path, help="a video or a recording")
    parser.add_argument(
        "--method",
        metavar="NAME",
        default=next(iter(METHOD_WORDS)),
        help="; ".join(f"{name}: {words}" for name, words in METHOD_WORDS.items())
        + " (default: %(default)s)",
    )
    parser.add_argument(
        "-o", "--output", metavar="angle.csv", type=any_path, help="default: into the recording"
    )
    parser.add_argument(
        "--camera", metavar="camera.toml", type=any_path, help="what `servosight calibrate` wrote"
    )
    parser.add_argument(
        "--light",
        metavar="X,Y",
        type=point,
        help="a light that shows the command (default: searched for) [px]",
    )
    parser.add_argument(
        "--marker", choices=("aruco", "apriltag"), help="follow a marker stuck on the surface"
    )
    parser.add_argument(
        "--id",
        metavar="N",
        type=whole,
        help="the marker's number (default: that of the marker that moves farthest)",
    )
    _add_hints(parser)
    _add_drawn(parser)
    add_json(parser)
    add_force(parser)


def _add_hints(parser: argparse.ArgumentParser) -> None:
    hints = parser.add_argument_group("which part is meant; each is enough by itself")
    hints.add_argument(
        "--pivot", metavar="X,Y", type=point, help="about where the centre of rotation is [px]"
    )
    hints.add_argument("--template", metavar="X,Y,W,H", type=box, help="box around the part [px]")
    hints.add_argument(
        "--tip", metavar="X,Y", type=point, help="a point of the part, far from its pivot [px]"
    )
    hints.add_argument(
        "--at",
        metavar="SECONDS",
        type=number,
        help="time of the frame in which these are given (default: the first frame's)",
    )
    hints.add_argument(
        "--pick",
        metavar="N",
        type=rank,
        default=1,
        help="number of the part, where the rotating parts are ranked by how much of the picture's "
        "change each explains (default: 1)",
    )
    second = parser.add_argument_group(
        "the horn beside the surface; written to horn.csv beside angle.csv where it is found"
    )
    second.add_argument(
        "--second",
        action="store_true",
        help="search for the horn also if it has no texture, or if the first part is pointed at",
    )
    second.add_argument(
        "--alone", action="store_true", help="measure one part, do not search for horn and pushrod"
    )
    second.add_argument(
        "--second-template",
        metavar="X,Y,W,H",
        type=box,
        help="box around the horn in the first frame [px]",
    )
    second.add_argument(
        "--second-pivot", metavar="X,Y", type=point, help="the horn's centre of rotation [px]"
    )


def _add_drawn(parser: argparse.ArgumentParser) -> None:
    drawn = parser.add_argument_group("pictures of the result")
    drawn.add_argument(
        "--draw",
        action="store_true",
        help="both, as track_overlay.mp4 and track_sheet.png beside angle.csv",
    )
    drawn.add_argument(
        "--overlay",
        metavar="FILE.mp4",
        type=any_path,
        help="the video with the result drawn on it",
    )
    drawn.add_argument(
        "--sheet", metavar="FILE.png", type=any_path, help="the frames with the largest uncertainty"
    )


def run(args: argparse.Namespace) -> None:
    """Track, write ``time_s,angle_deg,sigma_deg`` of each part, and draw what was found."""
    from servosight.app.commands.recording._linkage import between, parts_json
    from servosight.models.core import InputError
    from servosight.models.io import inspect_folder
    from servosight.sources import HORN, Part, Parts, Tracking, track_folder, track_video, video_of
    from servosight.tracking.calibration import read_camera

    parts = Parts(
        Part(args.pivot, args.template, args.tip, args.at, args.pick),
        Part(args.second_pivot, args.second_template)
        if args.second or args.second_template or args.second_pivot
        else None,
    )
    if args.alone and parts.second is not None:
        raise InputError(
            "--alone: a second part is asked for as well; expected one of the two, leave one out"
        )
    camera = read_camera(args.camera) if args.camera else None
    marker = _marker(args)
    if marker is not None and parts.second is not None:
        raise InputError(
            "--marker: follows one marker, and a second part is asked for as well; expected one of "
            "the two, leave one out"
        )
    folder = inspect_folder(args.source) if args.source.is_dir() else None
    if folder is not None:
        video_of(folder)  # before an angle.csv from elsewhere is offered for replacement
    output = args.output or (folder.angle if folder else args.source.with_name("angle.csv"))
    _check(args, output, parts.second is not None)
    unasked = not (args.alone or marker or _pointed(args)) and args.method == "refine"
    kept = unasked and not _may_write_horn(args, output)
    parts = replace(parts, linkage=unasked and not kept)
    how = Tracking(parts, args.method, camera, args.light, marker)
    with _drawing_refusals(output), progress(f"tracking {args.source}") as show:
        if folder is not None:
            tracks = track_folder(folder, output, how, show)
        else:
            tracks = track_video(args.source, output, how, show)
    out = console(args)
    for note in tracks[0].notes:
        out.print(f"note: {note}")
    if kept:
        out.print(f"note: {output.with_name(HORN)} is there already: no horn was looked for")
    places = [output, output.with_name(HORN)][: len(tracks)]
    for place, track in zip(places, tracks, strict=True):
        _tell(out, place, track)
    linkage, transmissions = tracks[0].linkage, between(tracks)
    for sentence in linkage.sentences if linkage is not None else ():
        out.print(sentence)
    for found in transmissions:
        out.print(f"between the two: {found.sentence}")
    _draw(args, output, tracks, out)
    write_json(args.json, parts_json(places, tracks, transmissions))


def _marker(args: argparse.Namespace) -> tuple[MarkerFamily, int | None] | None:
    """Family and number of the marker to follow; None for a part without one."""
    if args.marker is None and args.method != "marker":
        refuse_without("--marker", {"--id": args.id})
        return None
    family: MarkerFamily = args.marker or "aruco"
    return family, args.id


def _pointed(args: argparse.Namespace) -> bool:
    """Whether the user says which part is meant."""
    return any((args.pivot, args.template, args.tip, args.pick > 1))


def _may_write_horn(args: argparse.Namespace, output: Path) -> bool:
    """Whether a horn that nobody asked for replaces nothing that others wrote."""
    from servosight.sources import HORN, tracked_files

    place = output.with_name(HORN)
    return args.force or not place.exists() or HORN in tracked_files(output.parent)


@contextmanager
def _drawing_refusals(output: Path) -> Iterator[None]:
    """Write the picture of a refused video beside ``output``, unless a foreign file is there."""
    from servosight.models.core import InputError
    from servosight.tracking.core import TrackRefused
    from servosight.tracking.video.drawing import write_picture

    try:
        yield
    except TrackRefused as refused:
        place = output.with_name(REFUSED)
        try:
            check_target(place, Kind.PNG)
        except InputError:
            raise refused from None
        write_picture(place, refused.picture)
        raise InputError(f"{str(refused).rstrip('.')}; {place} shows what was found.") from refused


def _check(args: argparse.Namespace, output: Path, second: bool) -> None:
    """Refuse to replace what the tracker did not write; track.toml knows what it wrote."""
    from servosight.models.io import SHARED_FILE
    from servosight.sources import HORN, TRACK_FILE, tracked_files

    check_outputs(args)
    own = tracked_files(output.parent)
    names = [output.name, *([HORN] if second else [])]
    if output == args.source / "angle.csv":
        names += [TRACK_FILE, SHARED_FILE]
    for name in names:
        path = output.with_name(name)
        check_target(path, Kind.TABLE, force=args.force or name in own)
    if args.draw:
        for kind, path in _drawings(output).items():
            check_target(path, kind, force=args.force)


def _drawings(output: Path) -> dict[Kind, Path]:
    """Where --draw puts its two pictures."""
    names = {Kind.VIDEO: "track_overlay.mp4", Kind.PNG: "track_sheet.png"}
    return {kind: output.with_name(name) for kind, name in names.items()}


def _tell(out: Console, place: Path, track: Track) -> None:
    import numpy as np

    x, y = track.pivot_px
    out.print(
        f"{place}: {track.frames} frames, moved {np.ptp(track.angle_deg):.4g} deg, sigma "
        f"{np.median(track.sigma_deg):.2g} deg, pivot {x:.2f},{y:.2f} px"
    )
    missing = track.frames - int(np.sum(track.measured))
    if missing:
        out.print(
            f"note: {missing} frames left out: the part was not found, or the picture repeated"
        )


def _draw(args: argparse.Namespace, output: Path, tracks: Sequence[Track], out: Console) -> None:
    drawn = _drawings(output) if args.draw else {}
    overlay = args.overlay or drawn.get(Kind.VIDEO)
    sheet = args.sheet or drawn.get(Kind.PNG)
    if overlay is None and sheet is None:
        return
    from servosight.tracking.video.drawing import write_overlay, write_sheet

    for place, write in ((overlay, write_overlay), (sheet, write_sheet)):
        if place is None:
            continue
        with progress(f"drawing {place}") as show:
            write(place, tracks, lambda done, count: show("frames", done, count))
        out.print(f"{place}: drawn")
