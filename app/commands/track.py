"""Measure the surface's angle in a video, or in a recording's video."""

from __future__ import annotations

import argparse
from pathlib import Path

from servosight.app.arguments import box, point
from servosight.app.output import check_outputs, console


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight track``."""
    parser.add_argument("source", metavar="VIDEO|REC", type=Path, help="a video or a recording")
    parser.add_argument("--pivot", metavar="X,Y", type=point, help="centre of rotation [px]")
    parser.add_argument(
        "--template", metavar="X,Y,W,H", type=box, help="box around the surface, first frame [px]"
    )
    parser.add_argument(
        "--method",
        choices=("match", "refine"),
        default="refine",
        help="template matching as in the paper, or refined to the noise (default)",
    )
    parser.add_argument(
        "-o", "--output", metavar="angle.csv", type=Path, help="default: into the recording"
    )


def run(args: argparse.Namespace) -> None:
    """Track and write ``time_s,angle_deg,sigma_deg``."""
    import numpy as np

    from servosight.app.sources import track_folder, track_video, write_track
    from servosight.models.recording_io import inspect_folder

    check_outputs(args)
    options = {"pivot": args.pivot, "template": args.template, "method": args.method}
    if args.source.is_dir():
        folder = inspect_folder(args.source)
        output = args.output or folder.angle
        track = track_folder(folder, output, **options)
    else:
        output = args.output or args.source.with_name("angle.csv")
        track = track_video(args.source, **options)
        write_track(output, track)
    out = console(args)
    x, y = track.pivot_px
    out.print(
        f"{output}: {track.frames} frames, moved {np.ptp(track.angle_deg):.4g} deg, sigma "
        f"{np.median(track.sigma_deg):.2g} deg, pivot {x:.2f},{y:.2f} px"
    )
    missing = track.frames - int(np.sum(track.measured))
    if missing:
        out.print(
            f"note: {missing} frames left out: the surface was not found, or the picture repeated"
        )
