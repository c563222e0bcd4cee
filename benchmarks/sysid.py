"""mujoco.sysid, given by hand what is missing, beside `diagnose --auto`, which is given nothing.

Both read the same recordings of the twin, 20 s at 120 Hz; both times are CPU time over all cores,
so that other work on the machine weighs on neither. Writes docs/measured/sysid.md.
"""

from __future__ import annotations

import argparse
import logging
import time
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

from peers.mujoco_sysid import COULOMB, LINEAR, ManualModel, PeerFit, backlash, by_sysid
from servosight.diagnose import diagnose, predictions
from servosight.diagnose.residuals import rms
from servosight.identify.fit import identify
from servosight.models.core import Camera, Recording, write_text
from servosight.models.effects import catalogue
from servosight.models.excitation import standard
from servosight.scenarios.settings import LinearServo
from servosight.sim.run import angle_recording, run

PAGE = Path(__file__).resolve().parent.parent / "docs" / "measured" / "sysid.md"
NOISE_DEG, RATE_HZ = 0.03, 120.0
HIDDEN: Mapping[str, Mapping[str, Mapping[str, float]]] = {
    "nothing": {},
    "Coulomb friction": {"coulomb_friction": {"level": 1.0}},
    "backlash": {"backlash": {"gap": 1.5}},
}
GAPS_DEG = (0.2, 0.7, 2.0, 5.0)


def recorded(hidden: Mapping[str, Mapping[str, float]]) -> Recording:
    """What the twin did, with noise."""
    command = standard(20.0, 20.0, seed=1, rate_hz=240.0)
    trajectory = run(LinearServo(1.0, 0.02, 0.6, 0.3).bench(), hidden, command)
    return angle_recording(trajectory, Camera(rate_hz=RATE_HZ, exposure_s=0.0), NOISE_DEG, seed=1)


def by_servosight(recording: Recording) -> PeerFit:
    """Diagnose without any information but the recording."""
    began = time.process_time()
    found = diagnose([recording], catalogue=catalogue(), auto=True)
    cpu_s = time.process_time() - began
    error = rms([one.error_deg for one in predictions(found, [recording])])
    named = " + ".join(found.effects) or "nothing"
    return PeerFit(error / NOISE_DEG, cpu_s, 0, f"{found.verdict}: {named}")


def linear_by_servosight(recording: Recording) -> PeerFit:
    """The linear fit alone."""
    began = time.process_time()
    found = identify([recording], [], catalogue=catalogue(), method="gradient")
    cpu_s = time.process_time() - began
    return PeerFit(found.rmse_deg / NOISE_DEG, cpu_s, found.evaluations, "")


def page() -> str:
    """Every recording by both, as a table."""
    lines, ours_alone = [], []
    for hidden, effects in HIDDEN.items():
        recording = recorded(effects)
        alone = by_sysid(recording, ManualModel(LINEAR), NOISE_DEG)
        lines.append(_line(hidden, "mujoco.sysid, linear model (nothing given)", alone))
        if hidden == "Coulomb friction":
            lines.append(
                _line(
                    hidden,
                    "mujoco.sysid, given: frictionloss",
                    by_sysid(recording, ManualModel(COULOMB), NOISE_DEG),
                )
            )
        if hidden == "backlash":
            tries = [
                by_sysid(recording, ManualModel(backlash(gap), play=True), NOISE_DEG)
                for gap in GAPS_DEG
            ]
            best = min(tries, key=lambda one: one.over_noise)
            near = sum(one.over_noise < 1.05 * best.over_noise for one in tries)
            whole = PeerFit(
                best.over_noise,
                sum(one.cpu_s for one in tries),
                sum(one.rollouts for one in tries),
                f"{best.says}; {near} of {len(tries)} starts reached this",
            )
            lines.append(_line(hidden, "mujoco.sysid, given: eight numbers, four starts", whole))
        by_servosight(recording)  # the first call loads the kernel
        lines.append(
            _line(hidden, "servosight diagnose --auto (nothing given)", by_servosight(recording))
        )
        if hidden == "nothing":
            ours = linear_by_servosight(recording)
            ours_alone = [_line(hidden, "servosight identify --method gradient", ours)]
            ratio = alone.cpu_s / ours.cpu_s
        print(*lines[-3:], sep="\n", flush=True)
    return _PAGE.format(
        version=version("mujoco"),
        noise=NOISE_DEG,
        lines="\n".join(lines[:1] + ours_alone + lines[1:]),
        ratio=f"{ratio:.0f}",
    )


def _line(hidden: str, who: str, result: PeerFit) -> str:
    count = str(result.rollouts) if result.rollouts else ""
    return (
        f"| {hidden} | {who} | {result.over_noise:.3f} | {result.cpu_s:.2f} | {count} "
        f"| {result.says} |"
    )


_PAGE = """# Beside mujoco.sysid

Written by `python benchmarks/sysid.py` with mujoco {version}. Recordings are made by the twin: 20 s
at 120 Hz, noise {noise} deg. mujoco.sysid fits the numbers of a model that the user builds; it
starts from T 50 ms and xi 0.7 (truth 20 ms and 0.6) with its default optimiser. servosight is
given nothing. Errors are rms over all samples, over the noise. CPU seconds, over all cores.

| hidden | who | error / noise | CPU s | simulations | its report says |
| --- | --- | --- | --- | --- | --- |
{lines}

The linear fit of the record with nothing hidden takes mujoco.sysid {ratio} times the CPU time of
`identify`, whose time counts the estimate of noise and of uncertainty as well.
"""


if __name__ == "__main__":
    argparse.ArgumentParser(description=__doc__).parse_args()
    logging.disable(logging.WARNING)
    text = page()
    write_text(PAGE, text)
    print(text)
