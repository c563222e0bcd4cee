"""List serial ports and kinds of servo, and ask one what it measures."""

from __future__ import annotations

import argparse

from servosight.app.arguments import refuse_without
from servosight.app.terminal import console


def run(args: argparse.Namespace) -> None:
    """A line for each port, or the readings of ``--servo``; nothing moves."""
    from servosight.app.commands.bench._devices import limited_of, opened_servo
    from servosight.bench.servo import servo_kinds
    from servosight.bench.session import reading_words, serial_ports

    out = console(args)
    if args.servo is None:
        refuse_without("--servo ADDRESS", limited_of(args))
        ports = serial_ports()
        for port in ports:
            out.print(port)
        if not ports:
            out.print("no serial port on this computer: connect the servo's adapter")
        out.print(f"kinds: {', '.join(servo_kinds())}; an address is KIND:PORT?KEY=VALUE")
        return
    with opened_servo(args) as servo:
        out.print(f"{servo.name}: {reading_words(servo.read())}")
