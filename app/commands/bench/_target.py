"""A page to print: patterned discs for the surface, and a dial with a protractor."""

from __future__ import annotations

import argparse

from servosight.app.terminal import check_target, console
from servosight.models.base import Kind


def run(args: argparse.Namespace) -> None:
    """Write the page as a PNG file of A4."""
    check_target(args.output, Kind.PNG, force=args.force)
    from servosight.bench.target import BAR_MM, target_png
    from servosight.models.base import marked_png, write_bytes

    write_bytes(args.output, marked_png(target_png()))
    console(args).print(
        f"{args.output}: print it at 100 % on A4, and measure the line of {BAR_MM:g} mm; glue a "
        "disc to the surface, and the dial to whatever is to be checked with a pointer"
    )
