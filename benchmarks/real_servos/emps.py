"""EMPS, a linear axis: fits in degrees of position error, and their parameters in newtons."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat

from servosight.diagnose import diagnose, predictions
from servosight.diagnose.residuals import rms
from servosight.identify.fit import identify
from servosight.models.core import Actuator, Array
from servosight.models.effects import catalogue
from servosight.models.io.importers import Request
from servosight.models.io.importers.formats._mat import EMPS_SCALE, read_mat

from .logs import RunResult, data

TOLERANCE_DEG = 2e-4  # two micrometres
PUBLISHED = {"M [kg]": 95.11, "Fv [N s/m]": 203.5, "Fc [N]": 20.39, "offset [N]": -3.16}


MOST_SAMPLES = 5


@dataclass(frozen=True)
class Controller:
    """``v = kv (kp (reference - position) - speed)`` drives with gtau v; its speed is the
    difference of the position over ``samples`` of ``step_s``, and v is held for one of them.

    ``left`` is the share of the recorded v (rms) that this law leaves, by how many samples
    (``MOST_SAMPLES``,): the least tells how many.
    """

    gtau: float
    kv: float
    kp: float
    step_s: float
    left: tuple[float, ...]

    @classmethod
    def of(cls, file: Path) -> Controller:
        """From EMPS's own file, by the control voltage recorded there."""
        read: dict[str, Any] = loadmat(file)
        time_s, reference, position, volts = (
            np.asarray(read[name], float).ravel() for name in ("t", "qg", "qm", "vir")
        )
        gtau, kv, kp = (float(np.squeeze(read[name])) for name in ("gtau", "kv", "kp"))
        step_s = float(np.median(np.diff(time_s)))
        loop = kv * kp * (reference - position)
        left = [volts - (loop - kv * _speed(position, step_s, n)) for n in _samples()]
        return cls(gtau, kv, kp, step_s, tuple(rms([one]) / rms([volts]) for one in left))

    @property
    def samples(self) -> int:
        """Over how many samples the speed is measured."""
        return 1 + int(np.argmin(self.left))

    @property
    def stiffness(self) -> float:
        """Force at a position error of one metre [N/m]."""
        return self.gtau * self.kv * self.kp

    @property
    def late(self) -> dict[str, float]:
        """What the delays add to inertia and viscous friction, which a loop without shows less.

        To second order in the delays h/2 of the held voltage and n h/2 of the speed:
        ``g kv (n + 1) h/2 - S h^2/8`` and ``S h/2``.
        """
        half_s = 0.5 * self.step_s
        damped = self.gtau * self.kv * (self.samples + 1) * half_s
        return {
            "M [kg]": damped - 0.5 * self.stiffness * half_s**2,
            "Fv [N s/m]": self.stiffness * half_s,
        }


def _samples() -> range:
    return range(1, MOST_SAMPLES + 1)


def _speed(position: Array, step_s: float, samples: int) -> Array:
    """Its difference over so many samples (n,), zero at first."""
    apart = position[samples:] - position[:-samples]
    return np.concatenate([np.zeros(samples), apart / (samples * step_s)])


def emps() -> RunResult:
    """The linear model, one with Coulomb friction and the selected one; parameters in newtons."""
    file = data() / "emps" / "DATA_EMPS.mat"
    recording, controller = read_mat(file, Request()), Controller.of(file)
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
            name: {"rmse_um": 1e6 * rmse / EMPS_SCALE, "newtons": newtons(actuator, controller)}
            for name, (actuator, rmse) in fits.items()
        },
        "late": controller.late,
        "samples": controller.samples,
        "left": controller.left,
        "verdict": found.verdict,
        "candidates": [[one.effect, one.evidence] for one in found.candidates[:4]],
        "cpu_s": used,
    }


def newtons(actuator: Actuator, controller: Controller) -> dict[str, float]:
    """EMPS's parameters from a model in degrees of position error, its controller without delay.

    A position error of one metre is a force of S = gtau kv kp, so M = S T^2,
    Fv + gtau kv = 2 xi T S, and a torque of one degree is S / (degrees in a metre).
    """
    value, stiffness = actuator.value, controller.stiffness
    damping = controller.gtau * controller.kv
    found = {
        "M [kg]": stiffness * value("T") ** 2,
        "Fv [N s/m]": 2.0 * value("xi") * value("T") * stiffness - damping,
        "offset [N]": -stiffness * value("bias") / EMPS_SCALE,
    }
    if "coulomb_friction" in actuator.effects:
        found["Fc [N]"] = stiffness * value("coulomb_friction.level") / EMPS_SCALE
    return found
