"""Whatever happens on the wire: no hang, no limit exceeded, neutral where the link allows it."""

from __future__ import annotations

import math
import os

import numpy as np
import pytest
from support.wires import STAND_INS, STEP_DEG, Rig, rig, too_fast_deg

from servosight.bench.safety import Limits, released
from servosight.bench.servo import CommandLog, LinkLost, ServoFault, play
from servosight.bench.servo.codecs import dynamixel, feetech
from servosight.bench.wire import Faults

pytestmark = pytest.mark.pty

LIMITS = Limits(low_deg=-25.0, high_deg=25.0, rate_deg_s=250.0, ramp_deg_s=100.0, duration_s=2.0)
TIME = np.arange(0.0, 0.6, 0.02)
COMMAND = 20.0 * np.sin(2.0 * np.pi * 1.5 * TIME)
STRANGERS = {
    "board": b"",
    "dynamixel": dynamixel.status(2),
    "feetech": feetech.status(2),
    "maestro": b"",
}
LONGEST_S = 8.0
"""Command, ramps, three times 30 ms a question, and twice the 2 s for which a release tries."""
SEEDS = int(os.environ.get("SERVOSIGHT_FAULT_SEEDS", "25"))
"""Of each kind; more of them take longer than a test should."""
kinds = pytest.mark.parametrize("kind", list(STAND_INS))


def drawn(kind: str, seed: int) -> tuple[Faults, float]:
    """Faults of one to three sorts, and the mean lateness of the host."""
    random = np.random.default_rng(seed)
    sorts = random.choice(5, int(random.integers(1, 4)), replace=False)
    return Faults(
        seed=seed,
        lost=float(random.uniform(0.0, 0.01)) if 0 in sorts else 0.0,
        flipped=float(random.uniform(0.0, 0.01)) if 0 in sorts else 0.0,
        stalled_s=float(random.uniform(0.3, 1.2)) if 1 in sorts else math.inf,
        stall_s=float(random.uniform(0.02, 1.5)) if 1 in sorts else 0.0,
        unplugged_s=float(random.uniform(0.2, 1.3)) if 2 in sorts else math.inf,
        strange=0.3 if 3 in sorts else 0.0,
        stranger=STRANGERS[kind],
    ), float(random.uniform(0.0, 0.01)) if 4 in sorts else 0.0


def run(on: Rig, log: CommandLog) -> str:
    """One run; what it ended with."""
    try:
        with released(on.servo):
            play(on.servo, TIME, COMMAND, log)
    except (LinkLost, ServoFault) as error:
        return str(error)
    return ""


@kinds
def test_a_hundred_faulty_wires(kind: str) -> None:
    ended, whole = 0, 0
    for seed in range(SEEDS):
        faults, late_s = drawn(kind, seed + 100_000 * list(STAND_INS).index(kind))
        log = CommandLog()
        try:
            with rig(kind, LIMITS, faults, late_s=late_s) as on:
                start = on.clock.now()
                said = run(on, log)
                took = on.clock.now() - start
                on.clock.wait(on.clock.now() + 2.0)  # the servo's own watchdog
                far = on.far
        except LinkLost:
            continue  # the fault was there before the servo was
        case = f"seed {seed}: {faults}, late {late_s}: {said}"
        assert took < LONGEST_S, case
        goals = [goal.goal_deg for goal in far.received if goal.torque]
        spare = 2.0 * STEP_DEG[kind]
        assert all(abs(goal) <= 25.0 + spare for goal in goals), case
        assert too_fast_deg(far, 250.0) <= spare, case
        unplugged = math.isfinite(faults.unplugged_s)
        if not unplugged or kind == "board":
            assert not far.torque, case
            if goals:
                assert abs(goals[-1]) <= spare, case
        if said:
            ended += 1
            assert said.count(". ") == 0, case
        else:
            whole += 1
            assert len(log.sent) > 5, case
    assert ended >= 5
    assert whole >= 5


@kinds
@pytest.mark.parametrize("interrupt", [KeyboardInterrupt, RuntimeError])
def test_an_interrupted_run_ends_at_neutral(kind: str, interrupt: type[BaseException]) -> None:
    with rig(kind, LIMITS) as on:
        wait, stop = on.clock.wait, on.clock.now() + 0.4

        def interrupted(until_s: float, fd: int | None = None) -> bool:
            nonlocal stop
            if on.clock.now() > stop:
                stop = math.inf
                raise interrupt
            return wait(until_s, fd)

        on.clock.wait = interrupted  # type: ignore[method-assign]
        log = CommandLog()
        with pytest.raises(interrupt), released(on.servo):
            play(on.servo, TIME, COMMAND, log)
        wait(on.clock.now() + 0.1)
        assert not on.far.torque
        assert on.far.received[-2].goal_deg == pytest.approx(0.0, abs=2.0 * STEP_DEG[kind])
        assert too_fast_deg(on.far, 250.0) <= 2.0 * STEP_DEG[kind]
        assert log.sent
