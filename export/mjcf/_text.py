"""The MuJoCo model's text: one hinge for the motor, and what hangs on it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from xml.sax.saxutils import escape

from servosight.export.core import ExportRequest, mark_of, number, provenance_lines

STEPS_PER_T = 50.0
LONGEST_STEP_S = 5e-4
HARD = "0.9999 0.9999 0.001 0.5 2"
"""Impedance of friction and play: at MuJoCo's default softness friction creeps."""
FIN_SHARE = 1e-6
"""Least inertia behind play or spring, as a share of all: the motor hardly feels it."""
FIN_FRICTION_DEG = 1e-4
"""Friction that holds it [deg], large against that inertia."""
LINK = "1e-12"
HEAD = """<!-- {mark}

{model}

A servo for MuJoCo 4.0 and later: angles in radians, torques in N m for a stiffness of the position
loop of {stiffness} N m/rad (export with another stiffness to scale them). Control of the actuator
"{name}" is the command; the sensor "{name}_angle" is the angle of the surface. To put it into a
model of your own, copy the joints to its bodies, whose inertia then replaces that armature, and the
tendons, the actuator and the sensor beside it.
-->
"""


@dataclass(frozen=True)
class Servo:
    """Values of the model in SI units."""

    request: ExportRequest

    def deg(self, name: str, absent: float = 0.0) -> float:
        """A parameter in its own unit, ``absent`` where the model has no such effect."""
        actuator = self.request.actuator
        effect = name.partition(".")[0]
        return actuator.value(name) if effect in (*actuator.effects, name) else absent

    @property
    def stiffness(self) -> float:
        """Stiffness of the position loop [N m/rad]."""
        return self.request.options.stiffness_nm_rad

    @property
    def inertia(self) -> float:
        """All inertia [kg m^2]."""
        return self.stiffness * self.deg("T") ** 2

    @property
    def flexible(self) -> bool:
        """True where the surface hangs on a spring."""
        return "flexible_shaft" in self.request.actuator.effects

    @property
    def step_s(self) -> float:
        """Time step [s]: RK4 at T / 50 is exact to 1e-5 deg on a step of 20 deg."""
        usual = min(self.deg("T") / STEPS_PER_T, LONGEST_STEP_S)
        if self.flexible:
            highest = (1.0 - self.deg("flexible_shaft.inertia_ratio")) ** 0.5
            usual = min(usual, 0.02 * highest / self.deg("flexible_shaft.frequency"))
        return self.request.options.step_s(usual)

    @property
    def damping(self) -> float:
        """Viscous damping of the linear core [N m s/rad]."""
        return 2.0 * self.deg("xi") * self.deg("T") * self.stiffness

    @property
    def friction_deg(self) -> float:
        """Sliding friction [deg of position error]."""
        names = ("coulomb_friction", "stribeck_friction", "presliding")
        return sum(self.deg(f"{name}.level") for name in names)

    @property
    def drive_limit_deg(self) -> float:
        """Largest torque of the drive at rest [deg of position error], infinite for none."""
        names = ("torque_saturation.limit", "current_limit.limit", "speed_limit.stall")
        return min(self.deg(name, math.inf) for name in names)

    def torque(self, error_deg: float) -> float:
        """Torque [N m] of a position error [deg]."""
        return self.stiffness * math.radians(error_deg)


def model_text(request: ExportRequest) -> str:
    """The whole file."""
    servo = Servo(request)
    name = request.name
    head = HEAD.format(
        mark=mark_of("mjcf"),
        model=escape("\n".join(provenance_lines(request))).replace("--", "- -"),
        stiffness=number(servo.stiffness),
        name=name,
    )
    body = (
        f'<mujoco model="{name}">\n'
        f'  <compiler angle="radian"/>\n'
        f'  <option timestep="{number(servo.step_s)}" integrator="RK4"/>\n'
        f"  <worldbody>\n{_bodies(servo)}  </worldbody>\n"
        f"  <tendon>\n{_tendons(servo)}  </tendon>\n"
        f"  <actuator>\n{_actuator(servo)}  </actuator>\n"
        f"  <sensor>\n"
        f'    <tendonpos name="{name}_angle" tendon="{name}_angle"/>\n'
        f"  </sensor>\n"
        f"</mujoco>\n"
    )
    return head + body


def _bodies(servo: Servo) -> str:
    """Motor, the far side of a flexible shaft on it, and the surface behind a play beside it."""
    far = 0.0
    if servo.flexible:  # a massless far side still follows its spring
        far = max(servo.deg("flexible_shaft.inertia_ratio"), FIN_SHARE) * servo.inertia
    fin = FIN_SHARE * servo.inertia if servo.deg("backlash.gap") > 0.0 else 0.0
    shaft = ""
    if far > 0.0:
        omega = 2.0 * math.pi * servo.deg("flexible_shaft.frequency")
        damping = 2.0 * servo.deg("flexible_shaft.damping") * far * omega
        spring = {"stiffness": number(far * omega**2), "damping": number(damping)}
        shaft = _body(servo, ("far", "shaft"), far, spring, "      ")
    inner = _motor(servo, servo.inertia - far - fin)
    text = _body(servo, ("horn", "motor"), 0.0, inner, "    ", shaft)
    if fin > 0.0:
        held = _friction(servo, FIN_FRICTION_DEG)
        text += _body(servo, ("surface", "fin"), fin, held, "    ")
    return text


def _body(
    servo: Servo,
    names: tuple[str, str],
    inertia: float,
    joint: Mapping[str, str],
    indent: str,
    inside: str = "",
) -> str:
    """A body on a hinge about z; ``names`` of body and joint, attributes of the ``joint``."""
    body, hinge = (f"{servo.request.name}_{name}" for name in names)
    moment = number(inertia) if inertia > 0.0 else LINK
    given = "".join(f' {key}="{value}"' for key, value in joint.items())
    return (
        f'{indent}<body name="{body}">\n'
        f'{indent}  <inertial pos="0 0 0" mass="1e-6" diaginertia="{moment} {moment} {moment}"/>\n'
        f'{indent}  <joint name="{hinge}" type="hinge" axis="0 0 1"{given}/>\n'
        f"{inside}{indent}</body>\n"
    )


def _motor(servo: Servo, inertia: float) -> dict[str, str]:
    """Attributes of the motor's hinge.

    Springs and dampers are polynomials: in the angle, and in the speed and its size [rad, rad/s].
    """
    per_rad = math.degrees(1.0)
    damping = number(servo.damping)
    square = servo.torque(servo.deg("quadratic_drag.coefficient")) * per_rad**2
    # The first two terms of sine sin(angle); the constant part of gravity is the actuator's.
    sine = servo.torque(servo.deg("gravity_load.sine"))
    third = servo.torque(servo.deg("hinge_hardening.cubic")) * per_rad**3 - sine / 6.0
    level = servo.friction_deg
    given = {
        "armature": number(inertia),
        "damping": f"{damping} {number(square)} 0" if square > 0.0 else damping,
    }
    if (sine, third) != (0.0, 0.0):
        given["stiffness"] = f"{number(sine)} 0 {number(third)}"
    return given | (_friction(servo, level) if level > 0.0 else {})


def _friction(servo: Servo, level_deg: float) -> dict[str, str]:
    """Hard friction loss of a hinge: its time constant is the shortest that is stable."""
    return {
        "frictionloss": number(servo.torque(level_deg)),
        "solreffriction": f"{number(2.0 * servo.step_s)} 1",
        "solimpfriction": HARD,
    }


def _tendons(servo: Servo) -> str:
    name = servo.request.name
    play = servo.deg("backlash.gap")
    parts = [f"{name}_motor"]
    if servo.flexible:
        parts.append(f"{name}_shaft")
    behind = "".join(f'      <joint joint="{one}" coef="1"/>\n' for one in parts)
    if play == 0.0:  # MuJoCo refuses an empty range
        return f'    <fixed name="{name}_angle">\n{behind}    </fixed>\n'
    half = number(0.5 * math.radians(play))
    return (
        f'    <fixed name="{name}_angle">\n'
        f'      <joint joint="{name}_fin" coef="1"/>\n    </fixed>\n'
        f'    <fixed name="{name}_play" limited="true" range="-{half} {half}" '
        f'solreflimit="{number(2.0 * servo.step_s)} 1" solimplimit="{HARD}">\n{behind}'
        f'      <joint joint="{name}_fin" coef="-1"/>\n    </fixed>\n'
    )


def _actuator(servo: Servo) -> str:
    """Stiffness times (k command + bias - angle), limited, of a delayed command."""
    name = servo.request.name
    stiffness = servo.stiffness
    offset = servo.torque(servo.deg("bias") - servo.deg("gravity_load.cosine"))
    words = (
        f'    <general name="{name}" joint="{name}_motor" '
        f'gainprm="{number(stiffness * servo.deg("k"))}" biastype="affine" '
        f'biasprm="{number(offset)} {number(-stiffness)} 0"'
    )
    if math.isfinite(servo.drive_limit_deg):
        limit = number(servo.torque(servo.drive_limit_deg))
        words += f' forcerange="-{limit} {limit}"'
    delay = servo.deg("dead_time.delay")
    if delay > 0.0:
        samples = math.ceil(delay / servo.step_s) + 2
        words += f' delay="{number(delay)}" nsample="{samples}" interp="zoh"'
    return words + "/>\n"
