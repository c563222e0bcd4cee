"""Limits refuse what exceeds them, ramps keep within them, a servo is released whatever happens."""

from __future__ import annotations

import numpy as np
import pytest

from servosight.bench.safety import Limits, check_command, ramp, released
from servosight.models.core import InputError

TIME = np.arange(5) * 0.1


@pytest.mark.parametrize(
    ("limits", "angle", "said"),
    [
        (Limits(), [0, 0, 46, 0, 0], "row 3 asks for 46 deg, expected -45 to 45 deg"),
        (Limits(), [0, -45.1, 0, 0, 0], "row 2 asks for -45.1 deg"),
        (Limits(rate_deg_s=50), [0, 0, 6, 6, 6], "row 3 asks for 60 deg/s, expected at most 50"),
        (Limits(acceleration_deg_s2=50), [0, 1, 1, 1, 1], "row 3 asks for -100 deg/s2"),
        (Limits(duration_s=0.3), [0, 0, 0, 0, 0], "lasts 0.4 s, expected at most 0.3 s"),
        (Limits(), [0, 0, np.nan, 0, 0], "not a finite number"),
    ],
)
def test_a_command_beyond_the_limits_is_refused(
    limits: Limits, angle: list[float], said: str
) -> None:
    with pytest.raises(InputError, match=said):
        check_command(limits, TIME, np.array(angle, dtype=float), "u.csv")


def test_a_command_at_the_limits_passes() -> None:
    limits = Limits(low_deg=-1, high_deg=1, rate_deg_s=10, acceleration_deg_s2=200, duration_s=0.4)
    check_command(limits, TIME, np.array([0.0, 1.0, 0.0, -1.0, 0.0]))


@pytest.mark.parametrize("times", [[0, 1, 1, 2, 3], [0, 2, 1, 3, 4]])
def test_times_that_do_not_increase_are_refused(times: list[float]) -> None:
    with pytest.raises(InputError, match="do not increase"):
        check_command(Limits(), np.array(times, dtype=float), np.zeros(5))


@pytest.mark.parametrize(
    "keys",
    [
        {"low_deg": 10.0, "high_deg": 5.0},
        {"neutral_deg": 50.0},
        {"rate_deg_s": 0.0},
        {"duration_s": float("nan")},
        {"high_deg": 720.0},
    ],
)
def test_limits_that_are_none_are_refused(keys: dict[str, float]) -> None:
    with pytest.raises(InputError, match="limits: key"):
        Limits(**keys)  # type: ignore[arg-type]


@pytest.mark.parametrize("limits", [Limits(), Limits(rate_deg_s=20.0, acceleration_deg_s2=100.0)])
@pytest.mark.parametrize(("start", "end"), [(0.0, 40.0), (-44.0, 45.0), (3.0, 3.0), (0.0, 0.01)])
def test_a_ramp_keeps_within_the_limits(limits: Limits, start: float, end: float) -> None:
    time_s, angle_deg = ramp(limits, start, end)
    check_command(limits, time_s, angle_deg)
    assert angle_deg[0] == start
    assert angle_deg[-1] == end
    assert np.abs(np.diff(angle_deg) / np.diff(time_s)).max() <= limits.ramp_rate_deg_s * (1 + 1e-9)


class Servo:
    """Notes what is done to it."""

    def __init__(self, fails: bool = False) -> None:
        self.done: list[str] = []
        self.fails = fails

    def arm(self) -> None:
        self.done.append("arm")

    def release(self) -> None:
        self.done.append("release")
        if self.fails:
            raise InputError("no answer")


@pytest.mark.parametrize("reason", [KeyboardInterrupt, InputError, OSError, SystemExit])
def test_every_end_releases_the_servo(reason: type[BaseException]) -> None:
    servo = Servo()
    with pytest.raises(reason), released(servo):
        raise reason
    assert servo.done == ["arm", "release"]


def test_the_first_reason_is_the_one_that_is_raised() -> None:
    servo = Servo(fails=True)
    with pytest.raises(KeyboardInterrupt) as caught, released(servo):
        raise KeyboardInterrupt
    assert caught.value.__notes__ == ["and the servo could not be released: no answer"]


def test_a_release_that_fails_is_said() -> None:
    with pytest.raises(InputError, match="no answer"), released(Servo(fails=True)):
        pass
