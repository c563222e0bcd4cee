"""Calibrate a camera's lens, and the surface's plane, from pictures of a board."""

from __future__ import annotations

import argparse
from pathlib import Path

from servosight.app.arguments import add_force, any_path, number, whole
from servosight.app.terminal import check_outputs, console
from servosight.models.base import Kind


def configure(parser: argparse.ArgumentParser) -> None:
    """Arguments of ``servosight calibrate``."""
    parser.add_argument(
        "sources",
        metavar="IMAGE|VIDEO",
        nargs="*",
        default=[],
        type=any_path,
        help="the board, in many poses",
    )
    parser.add_argument(
        "--board",
        choices=("checkerboard", "aruco"),
        default="checkerboard",
        help="what was filmed; aruco is a ChArUco board of 4x4 markers (default: checkerboard)",
    )
    for name, words in (("columns", "squares in a row"), ("rows", "squares in a column")):
        parser.add_argument(f"--{name}", metavar="N", type=whole, required=True, help=words)
    parser.add_argument(
        "--square-mm",
        metavar="MM",
        type=number,
        default=10.0,
        help="a square's side (default: 10)",
    )
    parser.add_argument(
        "--plane", metavar="IMAGE", type=any_path, help="the board lying in the surface's plane"
    )
    parser.add_argument(
        "--print", metavar="FILE.png", type=any_path, help="write the board to print"
    )
    parser.add_argument(
        "-o", "--output", metavar="camera.toml", type=any_path, help="default: camera.toml"
    )
    add_force(parser)


def run(args: argparse.Namespace) -> None:
    """Find the board, fit the camera, write camera.toml."""
    from servosight.models.base import InputError

    for name, value, least in (("columns", args.columns, 3), ("rows", args.rows, 3)):
        if not least <= value <= 60:
            raise InputError(f"--{name} is {value}; expected {least} to 60 squares, count them.")
    if not 0.0 < args.square_mm < 1e4:
        raise InputError(f"--square-mm is {args.square_mm:g}; expected a side above 0 mm.")
    sources = args.sources or ([args.plane] if args.plane else [])
    if sources and args.output is None:
        args.output = Path("camera.toml")
    check_outputs(args, Kind.CAMERA)
    from servosight.tracking.calibration import Board, calibrate, read_views, write_camera

    board = Board(args.board, args.columns, args.rows, args.square_mm)
    out = console(args)
    if args.print is not None:
        from servosight.tracking.calibration import write_picture

        write_picture(args.print, board.picture())
        out.print(f"{args.print}: print it flat, and measure a square for --square-mm")
    if not sources:
        if args.print is None:
            raise InputError(
                "calibrate: no pictures are named; expected images or a video of the board, or "
                "--print FILE.png for one to print."
            )
        return
    result = calibrate(read_views(sources), board, args.plane)
    write_camera(args.output, result)
    for name, error in result.errors_px.items():
        out.print(f"{name}: {error:.3f} px rms")
    lens = result.camera.lens
    if lens is not None:
        k1, k2, p1, p2, k3 = lens.distortion
        out.print(
            f"focal length {lens.focal_px[0]:.1f}, {lens.focal_px[1]:.1f} px, k1 {k1:.4g}, k2 "
            f"{k2:.4g}, p1 {p1:.3g}, p2 {p2:.3g}, k3 {k3:.4g}"
        )
    plane = "with" if result.camera.onto is not None else "without"
    out.print(f"{args.output}: {plane} the plane of motion; {result.quality}")
    out.print("Next: servosight track VIDEO --camera " + str(args.output))
