"""List the cameras and their modes, and measure the real frame rate of one."""

from __future__ import annotations

import argparse

from servosight.app.arguments import refuse_without
from servosight.app.terminal import console

_FRAMES = 90


def run(args: argparse.Namespace) -> None:
    """A line for each camera, or the measured rate of ``--camera``."""
    from servosight.app.commands.bench._devices import opened_camera, stated_of
    from servosight.bench.camera import list_cameras
    from servosight.bench.session import measure_camera

    out = console(args)
    if args.camera is None:
        refuse_without("--camera ADDRESS", stated_of(args))
        found = list_cameras()
        for one in found:
            out.print(str(one))
        if not found:
            out.print(
                "no camera of Video4Linux on this computer; name a stream or a file with --camera"
            )
        return
    with opened_camera(args) as camera:
        seen = measure_camera(camera, _FRAMES)
    width, height = camera.stream.size
    out.print(
        f"{camera.name}: {width} x {height}, {camera.stream.coding}, {seen.rate_hz:.3f} frames/s "
        f"measured over {seen.frames} frames, {seen.lost} lost, stamps jitter by "
        f"{1e3 * seen.jitter_s:.2f} ms"
    )
    out.print(f"a stamp is {seen.meaning}")
    for name, value in camera.stream.settings:
        out.print(f"  {name} = {value:g}")
