"""Play a command on a servo, and keep what was sent and what came back."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from servosight.bench.safety import check_command
from servosight.bench.servo._protocol import LinkLost, Reading, StoredPlayback
from servosight.bench.servo._supervised import SupervisedServo
from servosight.models.core import Array

_LONGER, _SPARE_S = 1.1, 2.0
"""A device that plays may be slow by 10 %, and start and end within 2 s."""
_SPARE = 1.5
"""A reading is taken where this many times the last one's duration is left before the next row."""


@dataclass(kw_only=True)
class CommandLog:
    """What a run has sent and read so far; whole up to the moment at which a run breaks off.

    Times are the host's monotonic clock in s. ``sent`` holds (time, angle in deg) of each goal as
    the servo was told it. ``light_s`` is when the coded light began (``bench.light``), where the
    servo's board has one.
    """

    sent: list[tuple[float, float]] = field(default_factory=list)
    readings: list[Reading] = field(default_factory=list)
    light_s: float | None = None


def play(
    servo: SupervisedServo,
    time_s: Array,
    angle_deg: Array,
    log: CommandLog,
    source: str = "command.csv",
) -> None:
    """Play a command, (rows,) each, on an armed servo, and note it in ``log`` as it goes.

    The command is held to the limits before anything moves. The servo goes to the first row by a
    ramp, which is not part of the log. Rows are sent when they are due; where the link is slower
    than the rows, the latest one due is. Readings are taken in the time between. A device that
    plays stored commands gets the command that holds at each of its samples.
    """
    check_command(servo.limits, time_s, angle_deg, source)
    servo.move_to(float(angle_deg[0]))
    if isinstance(servo.driver, StoredPlayback):
        _play_stored(servo, servo.driver, time_s, angle_deg, log)
    else:
        _play_rows(servo, time_s, angle_deg, log)


def _play_rows(servo: SupervisedServo, time_s: Array, angle_deg: Array, log: CommandLog) -> None:
    clock = servo.clock
    due = clock.now() + (time_s - time_s[0])
    row, cost = 0, 0.0
    while row < len(due):
        clock.wait(float(due[row]))
        row = max(row, int(np.searchsorted(due, clock.now(), side="right")) - 1)
        sent = servo.send(float(angle_deg[row]))
        assert servo.goal_deg is not None
        log.sent.append((sent, servo.goal_deg))
        row += 1
        if row == len(due) or clock.now() + _SPARE * cost < due[row]:
            start = clock.now()
            log.readings.append(servo.read())
            cost = clock.now() - start


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
    told = device.begin(angle_deg[row])
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
                servo.goal_deg = float(told[played - 1])
            servo.clock.wait(servo.clock.now() + 0.5 * device.period_s)
    finally:
        start, rate = device.start_and_rate()
        at = start + rate * sample_s[:played]
        log.light_s = start if played else None
        log.sent = list(zip(at.tolist(), told[:played].tolist(), strict=True))
