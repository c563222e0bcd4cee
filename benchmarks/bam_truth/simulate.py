"""Run BAM's simulator (`better-actuator-models`, Apache-2.0) in the environment that has it.

A request comes as JSON on standard input, the angles go as JSON to standard output. Nothing of
servosight is imported here: the environment has numpy, scipy, colorama and BAM alone.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import numpy as np
from bam.model import load_model
from bam.simulate import Simulator

SETTLE_S = 3.0


def main() -> None:
    """One servo, one arm, several commands."""
    request = json.load(sys.stdin)
    model = load_model(motor_name=request["motor"], model=request["model"])
    model.q_offset.value = 0.0
    actuator = model.actuator
    actuator.load_log({key: request[key] for key in ("kp", "mass", "arm_mass", "length")})
    constants = {name: one.value for name, one in model.get_parameters().items()}
    constants |= {key: getattr(actuator, key) for key in ("vin", "error_gain", "max_pwm")}
    constants["max_current"] = actuator.max_current
    constants["inertia"] = float(
        actuator.testbench.compute_mass(0.0, 0.0) + actuator.get_extra_inertia()
    )
    angles = [march(Simulator(model), request["step_s"], one) for one in request["runs"]]
    json.dump({"constants": constants, "angle_rad": angles}, sys.stdout)


def march(simulator: Any, step_s: float, run: dict[str, Any]) -> list[float]:
    """Angles [rad] at every step from the run's time zero on; it comes to rest before."""
    arrival, goals = np.array(run["time_s"]), run["goal_rad"]
    simulator.reset(goals[0])
    settle = round(SETTLE_S / step_s)
    found = []
    for n in range(-settle, round(run["duration_s"] / step_s) + 1):
        if n >= 0:
            found.append(float(simulator.q))
        row = max(int(np.searchsorted(arrival, n * step_s + 1e-9, side="right")) - 1, 0)
        volts = simulator.model.actuator.compute_control(
            goals[row], simulator.q, simulator.dq, step_s
        )
        simulator.step(volts, True, step_s)
    return found


if __name__ == "__main__":
    main()
