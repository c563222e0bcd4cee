"""Play a command on a servo, and keep what was sent and what came back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from servosight.bench.safety import check_command
from servosight.bench.servo._protocol import (
    LinkLost,
    PulseDriven,
    Reading,
    Sent,
    StoredPlayback,
)
from servosight.bench.servo._supervised import SupervisedServo
from servosight.models.core import Array

_LONGER, _SPARE_S = 1.1, 2.0
"""A device that plays may be slow by 10 %, and start and end within 2 s."""
_LAST_S = 0.1
"""How long the pulse with the last row is looked for: on it depends where a servo comes to rest
within its play or dead zone."""
_SPARE = 1.5
"""A reading is taken where this many times the last one's duration is left before the next row."""


@dataclass(kw_only=True)
class CommandLog:
    """What a run has sent and read so far; whole up to the moment at which a run breaks off.

    Times are the host's monotonic clock in s. ``sent`` holds each goal as the servo has it,
    rounded to the steps of its protocol, and ``sigma_s`` the standard deviation of their times.
    ``light_s`` is when the coded light began (``bench.light``), where the servo's board has one.
    """

    sent: list[Sent] = field(default_factory=list)
    sigma_s: float = 0.0
    readings: list[Reading] = field(default_factory=list)
    light_s: float | None = None


def play(
    servo: SupervisedServo,
    time_s: Array,
    angle_deg: Array,
    log: CommandLog,
    source: str = "command.csv",
    wait: Callable[[float], object] | None = None,
) -> None:
    """Play a command, (rows,) each, on an armed servo, and note it in ``log`` as it goes.

    The command is held to the limits before anything moves. The servo goes to the first row by a
    ramp, which is not part of the log. Rows are sent when they are due; where the link is slower
    than the rows, the latest one due is. Readings are taken in the time between. A device that
    plays stored commands gets the command that holds at each of its samples. ``wait`` waits until
    a time, and does on the way what is due; the clock's own by default.
    """
    check_command(servo.limits, time_s, angle_deg, source)
    servo.move_to(float(angle_deg[0]))
    if isinstance(servo.driver, StoredPlayback):
        _play_stored(servo, servo.driver, time_s, angle_deg, log)
    else:
        _play_rows(servo, time_s, angle_deg, log, wait or servo.clock.wait)


def _play_rows(
    servo: SupervisedServo,
    time_s: Array,
    angle_deg: Array,
    log: CommandLog,
    wait: Callable[[float], object],
) -> None:
    clock = servo.clock
    due = clock.now() + (time_s - time_s[0])
    pulses = servo.driver if isinstance(servo.driver, PulseDriven) else None
    row, cost = 0, 0.0
    try:
        while row < len(due):
            wait(float(due[row]))
            row = max(row, int(np.searchsorted(due, clock.now(), side="right")) - 1)
            log.sent.append(servo.send(float(angle_deg[row])))
            row += 1
            if row == len(due) or clock.now() + _SPARE * cost < due[row]:
                start = clock.now()
                log.readings.append(servo.read())
                cost = clock.now() - start
            if pulses is not None:
                last = row == len(due)
                pulses.follow(clock.now() + _LAST_S if last else float(due[row]))
    finally:
        if pulses is not None:
            log.sent, log.sigma_s = pulses.taken(log.sent)


def _play_stored(
    servo: SupervisedServo,
    device: StoredPlayback,
    time_s: Array,
    angle_deg: Array,
    log: CommandLog,
) -> None:
    """Let the device play, and note its samples by its clock as the host's clock sees that."""
    sample_s = np.arange(0.0, time_s[-1] - time_s[0] + 1e-9, device.period_s)
    row = np.searchsorted(time_s - time_s[0], sample_s + 1e-9, side="right") - 1
    goals_deg = device.begin(angle_deg[row])
    played, plays = 0, True
    until = servo.clock.now() + _LONGER * (sample_s[-1] + device.period_s) + _SPARE_S
    try:
        while plays:
            if servo.clock.now() > until:
                raise LinkLost(
                    f"{servo.name}: the command does not end; switch the board off and on"
                )
            plays, played = device.feed()
            if played:
                servo.goal_deg = float(goals_deg[played - 1])
            servo.clock.wait(servo.clock.now() + 0.5 * device.period_s)
    finally:
        start, rate = device.start_and_rate()
        at = start + rate * sample_s[:played]
        log.light_s = start if played else None
        log.sent = [
            Sent(*one) for one in zip(at.tolist(), goals_deg[:played].tolist(), strict=True)
        ]
