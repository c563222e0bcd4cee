"""Devices as the options name them."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from contextlib import contextmanager

from servosight.bench.camera import Given, OpenCamera, open_camera
from servosight.bench.safety import LIMIT_OPTIONS, Limits
from servosight.bench.servo import SupervisedServo, open_servo
from servosight.models.core import InputError


def stated_of(args: argparse.Namespace) -> dict[str, object]:
    """The options that state something of a camera, with their values."""
    return {f"--{name}": getattr(args, name) for name in ("exposure", "readout", "stamp")}


def limited_of(args: argparse.Namespace) -> dict[str, float | None]:
    """The options that limit a servo, with their values."""
    return {option: getattr(args, option[2:]) for option in LIMIT_OPTIONS.values()}


def limits_of(args: argparse.Namespace) -> Limits:
    """The limits that the options give."""
    given = limited_of(args)
    named = {key: given[option] for key, option in LIMIT_OPTIONS.items()}
    return Limits(**{key: value for key, value in named.items() if value is not None})


def given_of(args: argparse.Namespace) -> Given:
    """What the options state of the camera."""
    return Given(exposure_s=args.exposure, readout_s=args.readout, meaning=args.stamp)


@contextmanager
def opened_camera(args: argparse.Namespace) -> Iterator[OpenCamera]:
    """The camera of ``--camera``, closed in any case."""
    camera = open_camera(args.camera, given_of(args))
    try:
        yield camera
    finally:
        camera.close()


@contextmanager
def opened_servo(args: argparse.Namespace) -> Iterator[SupervisedServo]:
    """The servo of ``--servo``, released and closed in any case."""
    servo = open_servo(args.servo, limits_of(args))
    try:
        yield servo
    finally:
        servo.close()


def check_armed(args: argparse.Namespace) -> None:
    """Raise InputError without ``--arm``."""
    if not args.arm:
        raise InputError(
            f"bench {args.action}: moves the servo; clear its way, and say so with --arm"
        )
