"""EMPS, a linear axis: fits in degrees of position error, and their parameters in newtons."""

from __future__ import annotations

import time
from collections.abc import Mapping

from servosight.diagnose import diagnose, predictions
from servosight.diagnose.residuals import rms
from servosight.identify.fit import identify
from servosight.models.core import Actuator
from servosight.models.effects import catalogue
from servosight.models.io.importers import Request
from servosight.models.io.importers.formats._mat import EMPS_SCALE, read_mat

from .logs import RunResult, data

TOLERANCE_DEG = 2e-4  # two micrometres
PUBLISHED = {"M [kg]": 95.11, "Fv [N s/m]": 203.5, "Fc [N]": 20.39, "offset [N]": -3.16}


def emps() -> RunResult:
    """The linear model, one with Coulomb friction and the selected one; parameters in newtons."""
    recording = read_mat(data() / "emps" / "DATA_EMPS.mat", Request())
    source = recording.details["source"]
    linear = identify([recording], [], catalogue=catalogue(), method="gradient")
    given = identify([recording], ["coulomb_friction"], catalogue=catalogue(), method="gradient")
    used = time.process_time()
    found = diagnose([recording], catalogue=catalogue(), auto=True, tolerance=TOLERANCE_DEG)
    used = time.process_time() - used
    rmse_deg = rms([one.error_deg for one in predictions(found, [recording])])
    fits = {
        "linear": (linear.actuator, linear.rmse_deg),
        "given: coulomb_friction": (given.actuator, given.rmse_deg),
        f"the ladder: {' + '.join(found.effects)}": (found.actuator, rmse_deg),
    }
    return {
        "fits": {
            name: {"rmse_um": 1e6 * rmse / EMPS_SCALE, "newtons": newtons(actuator, source)}
            for name, (actuator, rmse) in fits.items()
        },
        "verdict": found.verdict,
        "candidates": [[one.effect, one.evidence] for one in found.candidates[:4]],
        "cpu_s": used,
    }


def newtons(actuator: Actuator, source: Mapping[str, float]) -> dict[str, float]:
    """EMPS's parameters from a model in degrees of position error.

    Its amplifier drives with gtau v, v = kv (kp (reference - position) - speed): a position error
    of one metre is a force of S = gtau kv kp, so M = S T^2, Fv + gtau kv = 2 xi T S, and a torque
    of one degree is S / (degrees in a metre).
    """
    value = actuator.value
    stiffness = source["gtau"] * source["kv"] * source["kp"]
    found = {
        "M [kg]": stiffness * value("T") ** 2,
        "Fv [N s/m]": 2.0 * value("xi") * value("T") * stiffness - source["gtau"] * source["kv"],
        "offset [N]": -stiffness * value("bias") / EMPS_SCALE,
    }
    if "coulomb_friction" in actuator.effects:
        found["Fc [N]"] = stiffness * value("coulomb_friction.level") / EMPS_SCALE
    return found
