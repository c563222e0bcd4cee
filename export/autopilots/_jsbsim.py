"""``--to jsbsim``: a system file for JSBSim (https://jsbsim.sourceforge.net, XML version 2.0).

A chain of its flight control components: delay, rounding and rate limit of the command, hysteresis
in place of friction, gain, second-order filter, hysteresis for play, linkage.
"""

from __future__ import annotations

import tempfile
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from xml.sax.saxutils import escape

import numpy as np

from servosight.export.autopilots._series import (
    approximations,
    delay_s,
    lost_motion,
    rate_limits,
)
from servosight.export.core import (
    Exporter,
    ExportRequest,
    ExportTrial,
    Omission,
    Response,
    mark_of,
    number,
    omitted,
    provenance_lines,
)
from servosight.models.core import Array, either, rms, write_text

USUAL_STEP_S = 1.0 / 120.0
"""JSBSim's own time step."""
FINE_STEP_S = 1e-3
EXPRESSED = ("dead_time", "command_quantization", "rate_limit", "backlash", "linkage_geometry")
HEAD = """<?xml version="1.0" encoding="utf-8"?>
<!-- {mark}

{model}

Angles in degrees. The command is the property {name}/command-deg, the angle {name}/angle-deg and,
in radians, {name}/angle-rad. The delay holds at a time step of {step} s.
-->
<system name="{name}">
  <property value="0.0">{name}/command-deg</property>
  <channel name="{name}">
"""
TAIL = "  </channel>\n</system>\n"
AIRCRAFT = """<?xml version="1.0"?>
<fdm_config name="stand" version="2.0" release="ALPHA">
  <metrics>
    <wingarea unit="M2">1</wingarea><wingspan unit="M">1</wingspan><chord unit="M">1</chord>
    <location name="AERORP" unit="M"><x>0</x><y>0</y><z>0</z></location>
  </metrics>
  <mass_balance>
    <ixx unit="KG*M2">1</ixx><iyy unit="KG*M2">1</iyy><izz unit="KG*M2">1</izz>
    <emptywt unit="KG">1</emptywt>
    <location name="CG" unit="M"><x>0</x><y>0</y><z>0</z></location>
  </mass_balance>
  <ground_reactions/>
  <system file="servo"/>
  <aerodynamics><axis name="LIFT"/><axis name="ROLL"/></aerodynamics>
</fdm_config>
"""
RADIAN = "0.017453292519943295"


def _write(request: ExportRequest, path: Path) -> None:
    head = HEAD.format(
        mark=mark_of("jsbsim"),
        model=escape("\n".join(provenance_lines(request))).replace("--", "- -"),
        name=request.name,
        step=number(request.options.step_s(USUAL_STEP_S)),
    )
    write_text(path, head + "".join(_components(request)) + TAIL)


def _components(request: ExportRequest) -> list[str]:
    """The components in the order in which they run."""
    k, T, xi, bias = (request.actuator.value(name) for name in ("k", "T", "xi", "bias"))
    name, source, made = request.name, "command", []

    def add(kind: str, target: str, body: dict[str, str]) -> None:
        nonlocal source
        # A function reads its properties itself: an input would multiply it.
        given = {} if kind == "fcs_function" else {"input": f"{name}/{source}-deg"}
        lines = "".join(
            f"      <{key}>{text}</{key.split()[0]}>\n" for key, text in (given | body).items()
        )
        made.append(f'    <{kind} name="{name}/{target}-deg">\n{lines}    </{kind}>\n')
        source = target

    command: dict[str, str] = {}
    rates = rate_limits(request)
    if rates:
        command["rate_limit"] = number(min(rates.values()))
    if delay_s(request) > 0.0:
        command['delay type="time"'] = number(_buffer_s(request))
    if "command_quantization" in request.actuator.effects:
        add("fcs_function", "rounded", {"function": _rounded(request)})
    if command:
        add("actuator", "received", command)
    add("pure_gain", "goal", {"gain": number(k)})
    if lost_motion(request):
        add("actuator", "held", {"hysteresis_width": number(sum(lost_motion(request).values()))})
    second_order = {"c1": 0.0, "c2": 0.0, "c3": 1.0, "c4": T * T, "c5": 2.0 * xi * T, "c6": 1.0}
    add("second_order_filter", "motor", {key: number(one) for key, one in second_order.items()})
    linkage = "linkage_geometry" in request.actuator.effects
    surface = {"bias": number(bias)}
    if "backlash" in request.actuator.effects:
        surface = {"hysteresis_width": number(request.actuator.value("backlash.gap"))} | surface
    add("actuator", "horn" if linkage else "angle", surface)
    if linkage:
        add("fcs_function", "angle", {"function": _linkage(request)})
    made.append(
        f'    <pure_gain name="{name}/angle-rad">\n      <input>{name}/angle-deg</input>\n'
        f"      <gain>{RADIAN}</gain>\n    </pure_gain>\n"
    )
    return made


def _buffer_s(request: ExportRequest) -> float:
    """Length of JSBSim's buffer [s]: one of n steps delays by n - 1; a time is cut to whole steps.

    The filter's trapezoidal rule answers half a step early, which the delay makes good.
    """
    step_s = request.options.step_s(USUAL_STEP_S)
    return step_s * (round(delay_s(request) / step_s + 0.5) + 1.01)


def _rounded(request: ExportRequest) -> str:
    """step floor(u / step + 1/2)."""
    step = number(request.actuator.value("command_quantization.step"))
    steps = f"<quotient><p>{request.name}/command-deg</p><v>{step}</v></quotient>"
    return f"<product><v>{step}</v><floor><sum>{steps}<v>0.5</v></sum></floor></product>"


def _linkage(request: ExportRequest) -> str:
    """asin(horn (sin(angle + offset) - sin(offset))), held at the dead centre."""
    horn, offset = (request.actuator.value(f"linkage_geometry.{q}") for q in ("horn", "offset"))
    angle = f"<sum><p>{request.name}/horn-deg</p><v>{number(offset)}</v></sum>"
    moved = (
        f"<sin><product>{angle}<v>{RADIAN}</v></product></sin>"
        f"<v>{number(np.sin(np.radians(offset)))}</v>"
    )
    way = f"<product><v>{number(horn)}</v><difference>{moved}</difference></product>"
    way = f"<max><v>-1.0</v><min><v>1.0</v>{way}</min></max>"
    return f"<quotient><asin>{way}</asin><v>{RADIAN}</v></quotient>"


def _omissions(request: ExportRequest) -> tuple[Omission, ...]:
    play = {
        name: f"hysteresis of {width:.3g} deg before the dynamics"
        for name, width in lost_motion(request).items()
    }
    return omitted(request, EXPRESSED, approximations(request) | play)


def _run(request: ExportRequest, path: Path, trial: ExportTrial) -> Response:
    """Run the file at the time step asked for, and say what a finer one would give."""
    step_s = request.options.step_s(USUAL_STEP_S)
    time_s, angle = _simulated(path, request.name, trial, step_s)
    notes: tuple[str, ...] = ()
    if step_s > FINE_STEP_S:
        options = replace(request.options, sample_time_s=FINE_STEP_S)
        with tempfile.TemporaryDirectory() as folder:
            fine = Path(folder) / "fine.xml"
            _write(replace(request, options=options), fine)
            fine_time, fine_angle = _simulated(fine, request.name, trial, FINE_STEP_S)
        change = angle - np.interp(time_s, fine_time, fine_angle)
        how = either(f"sample_time_s={FINE_STEP_S:g}", f"--sample-time {FINE_STEP_S:g}")
        notes = (
            f"JSBSim was run at steps of {step_s:.4g} s; at {FINE_STEP_S:g} s, export with {how}, "
            f"the angle changes by {rms(change):.3g} deg rms",
        )
    return Response(time_s=time_s, angle_deg=angle, notes=notes)


def _simulated(path: Path, name: str, trial: ExportTrial, step_s: float) -> tuple[Array, Array]:
    """Times [s] and angle [deg] of the system on an aircraft of nothing else."""
    import jsbsim

    recording = trial.recording
    first, last = recording.time_s[[0, -1]]
    time_s = first + step_s * np.arange(int((last - first) / step_s) + 1)
    command = recording.command_at(time_s)
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / "aircraft" / "stand"
        (place / "Systems").mkdir(parents=True)
        (place / "stand.xml").write_text(AIRCRAFT, encoding="utf-8")
        (place / "Systems" / "servo.xml").write_bytes(path.read_bytes())
        jsbsim.FGJSBBase().debug_lvl = 0  # type: ignore[no-untyped-call]
        fdm = jsbsim.FGFDMExec(folder)
        fdm.set_debug_level(0)
        fdm.set_dt(step_s)
        if not fdm.load_model("stand"):
            raise RuntimeError("JSBSim refused the system file")
        fdm.run_ic()
    for _ in range(_settling(command[0], step_s)):
        fdm[f"{name}/command-deg"] = float(command[0])
        fdm.run()
    angle = np.empty(time_s.size)
    for index, value in enumerate(command):
        fdm[f"{name}/command-deg"] = float(value)
        fdm.run()
        angle[index] = fdm[f"{name}/angle-deg"]
    return time_s, angle


def _settling(first_deg: float, step_s: float) -> int:
    """Steps until the blocks, which JSBSim starts at zero, rest at another first command."""
    return 1 if first_deg == 0.0 else int(SETTLING_S / step_s)


SETTLING_S = 10.0


def _missing() -> str | None:
    if find_spec("jsbsim") is None:
        return "JSBSim is not installed (pip install jsbsim)"
    return None


JSBSIM = Exporter(target="JSBSim", write=_write, omissions=_omissions, run=_run, missing=_missing)
"""The exporter of ``--to jsbsim``."""
