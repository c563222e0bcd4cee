"""mujoco.sysid, told by hand what is missing, beside `diagnose --auto`, untold.

Both read the same recordings of the twin, 20 s at 120 Hz; both times are CPU time over all cores,
so that other work on the machine weighs on neither. Writes docs/measured/sysid.md.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from mujoco import sysid

from servosight.diagnose import diagnose, predictions
from servosight.diagnose.residuals import rms
from servosight.identify.fit import identify
from servosight.models.core import Array, Camera, Recording, write_text
from servosight.models.effects import catalogue
from servosight.models.excitation import standard
from servosight.scenarios.scenario import LinearServo
from servosight.sim.run import angle_recording, run

Start = Mapping[str, tuple[float, float, float]]
Setter = Callable[[mujoco.MjSpec, float], None]

PAGE = Path(__file__).resolve().parent.parent / "docs" / "measured" / "sysid.md"
NOISE_DEG, RATE_HZ, STEP_S = 0.03, 120.0, 1.0 / 960.0
HIDDEN: Mapping[str, Mapping[str, Mapping[str, float]]] = {
    "nothing": {},
    "Coulomb friction": {"coulomb_friction": {"level": 1.0}},
    "backlash": {"backlash": {"gap": 1.5}},
}
GAPS_DEG = (0.2, 0.7, 2.0, 5.0)
STIFF = (2.0 * STEP_S, 1.0)
HARD = (0.9999, 0.9999, 0.001, 0.5, 2.0)


def recorded(hidden: Mapping[str, Mapping[str, float]]) -> Recording:
    """What the twin did, with noise."""
    command = standard(20.0, 20.0, seed=1, rate_hz=240.0)
    trajectory = run(LinearServo(1.0, 0.02, 0.6, 0.3).bench(), hidden, command)
    return angle_recording(trajectory, Camera(rate_hz=RATE_HZ, exposure_s=0.0), NOISE_DEG, seed=1)


@dataclass(frozen=True)
class Hand:
    """A model built by hand: which numbers are free as (start, low, high), in units of the loop.

    The stiffness of the position loop is 1, so inertia is T^2 and damping 2 xi T.
    """

    numbers: Start
    play: bool = False

    def spec(self) -> mujoco.MjSpec:
        """The bench as a user would draw it: a motor's hinge, with play a fin on a tendon."""
        spec = mujoco.MjSpec()
        spec.option.timestep = STEP_S
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
        body = spec.worldbody.add_body(
            name="motor", explicitinertial=True, mass=1e-6, inertia=[1e-9] * 3
        )
        body.add_joint(
            name="motor", axis=[0, 0, 1], solref_friction=STIFF, solimp_friction=HARD
        ).type = mujoco.mjtJoint.mjJNT_HINGE
        drive = spec.add_actuator(name="drive", target="motor", trntype=mujoco.mjtTrn.mjTRN_JOINT)
        drive.set_to_position(kp=1.0)
        seen = "motor"
        if self.play:
            fin = spec.worldbody.add_body(
                name="fin", explicitinertial=True, mass=1e-6, inertia=[1e-9] * 3
            )
            fin.add_joint(
                name="fin", axis=[0, 0, 1], solref_friction=STIFF, solimp_friction=HARD
            ).type = mujoco.mjtJoint.mjJNT_HINGE
            play = spec.add_tendon(
                name="play", limited=True, range=[-0.01, 0.01], solref_limit=STIFF
            )
            play.solimp_limit = HARD
            play.wrap_joint("motor", 1.0)
            play.wrap_joint("fin", -1.0)
            seen = "fin"
        spec.add_sensor(
            name="angle",
            type=mujoco.mjtSensor.mjSENS_JOINTPOS,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            objname=seen,
        )
        return spec

    def parameters(self) -> sysid.ParameterDict:
        """The free numbers as its optimiser wants them."""
        table = sysid.ParameterDict()
        for name, (start, low, high) in self.numbers.items():
            table.add(
                sysid.Parameter(name, start, low, high, modifier=partial(_modify, SETTERS[name]))
            )
        return table


def _modify(setter: Setter, spec: mujoco.MjSpec, parameter: Any) -> None:
    setter(spec, float(parameter.value[0]))


def _gain(spec: mujoco.MjSpec, value: float) -> None:
    spec.actuator("drive").gainprm[0] = value


def _bias(spec: mujoco.MjSpec, value: float) -> None:
    spec.actuator("drive").biasprm[0] = value


def _inertia(spec: mujoco.MjSpec, value: float) -> None:
    spec.joint("motor").armature = value


def _damping(spec: mujoco.MjSpec, value: float) -> None:
    spec.joint("motor").damping = [value, 0.0, 0.0]


def _friction(joint: str, spec: mujoco.MjSpec, value: float) -> None:
    spec.joint(joint).frictionloss = value


def _gap(spec: mujoco.MjSpec, value: float) -> None:
    spec.tendon("play").range = [-0.5 * value, 0.5 * value]


def _fin_inertia(spec: mujoco.MjSpec, value: float) -> None:
    spec.joint("fin").armature = value


SETTERS: Mapping[str, Setter] = {
    "k": _gain,
    "bias": _bias,
    "T^2": _inertia,
    "2 xi T": _damping,
    "friction": partial(_friction, "motor"),
    "gap": _gap,
    "fin inertia": _fin_inertia,
    "fin friction": partial(_friction, "fin"),
}
LINEAR: Start = {
    "k": (1.0, 0.2, 3.0),
    "bias": (0.0, -0.2, 0.2),
    "T^2": (0.0025, 1e-4, 0.02),
    "2 xi T": (0.07, 1e-3, 0.2),
}
COULOMB: Start = {**LINEAR, "friction": (0.003, 0.0, 0.2)}


def backlash(gap_deg: float) -> Start:
    """Eight numbers, the last three of the gap and the light fin behind it."""
    return {
        **COULOMB,
        "gap": (math.radians(gap_deg), 1e-4, 0.2),
        "fin inertia": (1e-8, 1e-9, 1e-5),
        "fin friction": (1e-5, 0.0, 1e-3),
    }


@dataclass(frozen=True)
class Result:
    """How near a fit came, what it cost, what its report says."""

    over_noise: float
    cpu_s: float
    rollouts: int
    says: str


def by_sysid(recording: Recording, hand: Hand) -> Result:
    """Fit a hand-built model with mujoco.sysid's own optimiser and read its report."""
    spec = hand.spec()
    model = spec.compile()
    time_s = STEP_S * np.arange(round(recording.duration_s / STEP_S) + 2)
    at = np.searchsorted(recording.command_time_s, time_s + 1e-9, side="right") - 1
    control = sysid.TimeSeries(time_s, np.radians(recording.command_deg[at])[:, None])
    # A rollout's sensors are those of the step's beginning, under the time of its end.
    measured = sysid.TimeSeries.from_names(
        recording.time_s + STEP_S, np.radians(recording.angle_deg)[:, None], model
    )
    start = np.full(model.nq, math.radians(float(recording.angle_deg[:3].mean())))
    state = sysid.create_initial_state(model, start, np.zeros(model.nv), np.zeros(0))
    sequences = [sysid.ModelSequences("bench", spec, "record", state, control, measured)]
    residual = sysid.build_residual_fn(models_sequences=sequences)
    rollouts = 0

    def counted(x: Array, table: Any, **options: Any) -> Any:
        nonlocal rollouts
        rollouts += 1 if x.ndim == 1 else x.shape[1]
        return residual(x, table, **options)

    initial = hand.parameters()
    began = time.process_time()
    found, outcome = sysid.optimize(initial, counted, verbose=False)
    cpu_s = time.process_time() - began
    _, predicted, seen = residual(found.as_vector(), found)
    error_deg = np.degrees(predicted[0][0].data - seen[0][0].data)
    report = sysid.default_report(
        sequences, initial, found, residual, outcome, generate_videos=False
    )
    said = "No Issues Detected" if "No Issues Detected" in report.build() else "a warning"
    return Result(float(np.sqrt(np.mean(error_deg**2))) / NOISE_DEG, cpu_s, rollouts, said)


def by_us(recording: Recording) -> Result:
    """Diagnose untold."""
    began = time.process_time()
    found = diagnose([recording], catalogue=catalogue(), auto=True)
    cpu_s = time.process_time() - began
    error = rms([one.error_deg for one in predictions(found, [recording])])
    named = " + ".join(found.effects) or "nothing"
    return Result(error / NOISE_DEG, cpu_s, 0, f"{found.verdict}: {named}")


def linear_by_us(recording: Recording) -> Result:
    """The linear fit alone."""
    began = time.process_time()
    found = identify([recording], [], catalogue=catalogue(), method="gradient")
    cpu_s = time.process_time() - began
    return Result(found.rmse_deg / NOISE_DEG, cpu_s, found.evaluations, "")


def page() -> str:
    """Every recording by both, as a table."""
    lines, linear = [], []
    for hidden, effects in HIDDEN.items():
        recording = recorded(effects)
        untold = by_sysid(recording, Hand(LINEAR))
        lines.append(_line(hidden, "mujoco.sysid, linear model (untold)", untold))
        if hidden == "Coulomb friction":
            lines.append(
                _line(
                    hidden, "mujoco.sysid, told: frictionloss", by_sysid(recording, Hand(COULOMB))
                )
            )
        if hidden == "backlash":
            tries = [by_sysid(recording, Hand(backlash(gap), play=True)) for gap in GAPS_DEG]
            best = min(tries, key=lambda one: one.over_noise)
            near = sum(one.over_noise < 1.05 * best.over_noise for one in tries)
            whole = Result(
                best.over_noise,
                sum(one.cpu_s for one in tries),
                sum(one.rollouts for one in tries),
                f"{best.says}; {near} of {len(tries)} starts came so far",
            )
            lines.append(_line(hidden, "mujoco.sysid, told: eight numbers, four starts", whole))
        by_us(recording)  # the first call loads the kernel
        lines.append(_line(hidden, "servosight diagnose --auto (untold)", by_us(recording)))
        if hidden == "nothing":
            ours = linear_by_us(recording)
            linear = [_line(hidden, "servosight identify --method gradient", ours)]
            ratio = untold.cpu_s / ours.cpu_s
        print(*lines[-3:], sep="\n", flush=True)
    return _PAGE.format(
        version=version("mujoco"),
        noise=NOISE_DEG,
        lines="\n".join(lines[:1] + linear + lines[1:]),
        ratio=f"{ratio:.0f}",
    )


def _line(hidden: str, who: str, result: Result) -> str:
    count = str(result.rollouts) if result.rollouts else ""
    return (
        f"| {hidden} | {who} | {result.over_noise:.3f} | {result.cpu_s:.2f} | {count} "
        f"| {result.says} |"
    )


_PAGE = """# Beside mujoco.sysid

Written by `python benchmarks/sysid.py` with mujoco {version}. Recordings are made by the twin: 20 s
at 120 Hz, noise {noise} deg. mujoco.sysid fits the numbers of a model that the user builds; it
starts from T 50 ms and xi 0.7 (truth 20 ms and 0.6) with its default optimiser. servosight is told
nothing. Errors are rms over all samples, over the noise. CPU seconds, over all cores.

| hidden | who | error / noise | CPU s | simulations | its report says |
| --- | --- | --- | --- | --- | --- |
{lines}

The linear fit of the record with nothing hidden takes mujoco.sysid {ratio} times the CPU time of
`identify`, whose time counts the estimate of noise and of uncertainty as well.
"""


if __name__ == "__main__":
    logging.disable(logging.WARNING)
    text = page()
    write_text(PAGE, text)
    print(text)
