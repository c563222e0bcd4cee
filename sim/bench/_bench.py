"""The bench as a MuJoCo model: rotor, reducer, position loop and the surface on its hinge.

    rotor --reducer--> horn ==pushrod of equal horns== surface
                        |  hinge "motor"

The amplifier drives with ``loop_stiffness`` times the position error; braking by back-EMF and
bearings is viscous. Horn and surface turn as one unless a hidden effect comes between them
(:mod:`servosight.sim.effects`). Angles in the model are radians, about the z axis, which points at
the camera; gravity points down in the picture, along -y.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import mujoco

STEPS_PER_T = 50
"""Runge-Kutta of fourth order at T / 50: 1e-5 deg of error on a 20 deg step."""
LONGEST_STEP_S = 5e-4
SHORTEST_T_S = 0.002

HARD_IMPEDANCE = (0.9999, 0.9999, 0.001, 0.5, 2.0)
"""With :attr:`Assembly.hard_reference`, constraints as stiff as the step allows: at MuJoCo's
default softness friction creeps."""

STRONG_NM = 1e6
"""No limit, where MuJoCo requires one."""

_LINK_INERTIA = 1e-12  # MuJoCo requires some of moving bodies, kg m^2


@dataclass(frozen=True)
class BenchParameters:
    """The twin's physical truth, seen at the surface's hinge.

    ``gain`` is surface degrees per command degree (the amplifier's calibration, negative where the
    servo is mounted the other way round), ``bias_deg`` the angle at zero command.
    """

    rotor_inertia_kg_m2: float = 1e-8
    reducer_ratio: float = 118.3
    surface_inertia_kg_m2: float = 6e-5
    loop_stiffness_nm_rad: float = 0.5
    back_emf_damping_nms_rad: float = 0.009
    viscous_damping_nms_rad: float = 0.003
    gain: float = 1.0
    bias_deg: float = 0.0

    @classmethod
    def with_response(
        cls, k: float = 1.0, T: float = 0.02, xi: float = 0.6, bias_deg: float = 0.0
    ) -> BenchParameters:
        """A bench whose model is k / (T^2 s^2 + 2 xi T s + 1): inertia and damping follow.

        Three tenths of the inertia lie in the surface, a quarter of the damping in the bearings.
        ``T`` [s] is at least 2 ms.
        """
        if not (T >= SHORTEST_T_S and xi > 0.0):
            raise ValueError(f"expected T >= {SHORTEST_T_S} s and xi > 0, got T={T}, xi={xi}")
        stiffness = cls.loop_stiffness_nm_rad
        inertia = stiffness * T**2
        damping = 2.0 * xi * T * stiffness
        return cls(
            rotor_inertia_kg_m2=0.7 * inertia / cls.reducer_ratio**2,
            surface_inertia_kg_m2=0.3 * inertia,
            back_emf_damping_nms_rad=0.75 * damping,
            viscous_damping_nms_rad=0.25 * damping,
            gain=k,
            bias_deg=bias_deg,
        )

    @property
    def armature_kg_m2(self) -> float:
        """Rotor inertia behind the reducer."""
        return self.rotor_inertia_kg_m2 * self.reducer_ratio**2

    @property
    def inertia_kg_m2(self) -> float:
        """All inertia, at the surface's hinge."""
        return self.armature_kg_m2 + self.surface_inertia_kg_m2

    @property
    def damping_nms_rad(self) -> float:
        """All viscous damping, at the surface's hinge."""
        return self.back_emf_damping_nms_rad + self.viscous_damping_nms_rad

    @property
    def k(self) -> float:
        """Static gain of the effect-free twin [-]."""
        return self.gain

    @property
    def T(self) -> float:
        """Time constant of the effect-free twin, sqrt(J / K) [s]."""
        return math.sqrt(self.inertia_kg_m2 / self.loop_stiffness_nm_rad)

    @property
    def xi(self) -> float:
        """Damping ratio of the effect-free twin, D / (2 sqrt(J K)) [-]."""
        return (
            0.5 * self.damping_nms_rad / math.sqrt(self.inertia_kg_m2 * self.loop_stiffness_nm_rad)
        )

    def torque(self, error_deg: float) -> float:
        """Torque [N m] that the loop answers to a position error [deg]: the catalogue's unit."""
        return self.loop_stiffness_nm_rad * math.radians(error_deg)


@dataclass
class Assembly:
    """A bench under construction: what the hidden effects edit before it is compiled.

    ``surface`` names the hinges whose angles add up to the surface's angle, ``sensor`` the hinge
    with the potentiometer, ``amplifiers`` the actuators that drive the motor.
    """

    bench: BenchParameters
    spec: mujoco.MjSpec
    surface: list[str] = field(default_factory=lambda: ["motor"])
    sensor: str = "motor"
    amplifiers: list[mujoco.MjsActuator] = field(default_factory=list)

    @property
    def motor(self) -> mujoco.MjsJoint:
        """The motor's hinge, behind the reducer."""
        return self.spec.joint("motor")

    @property
    def hard_reference(self) -> tuple[float, float]:
        """Time constant [s] and damping of constraints: one step; MuJoCo's guard asks for two.

        The rate of 2 / step is within Runge-Kutta's stability limit (2.78 / step).
        """
        return float(self.spec.option.timestep), 1.0

    def amplifier(
        self, gain_nm_rad: float, low_nm: float = -STRONG_NM, high_nm: float = STRONG_NM
    ) -> mujoco.MjsActuator:
        """An amplifier with torque ``gain`` times (control - motor angle), within limits."""
        one = self.spec.add_actuator(trntype=mujoco.mjtTrn.mjTRN_JOINT, target="motor")
        one.set_to_position(kp=gain_nm_rad)
        one.forcelimited = True
        one.forcerange = [low_nm, high_nm]
        self.amplifiers.append(one)
        return one

    def hinge(self, body: mujoco.MjsBody, name: str) -> mujoco.MjsJoint:
        """Give ``body`` a hinge about z with hard constraints."""
        return body.add_joint(
            name=name,
            type=mujoco.mjtJoint.mjJNT_HINGE,
            axis=[0, 0, 1],
            solref_friction=self.hard_reference,
            solimp_friction=HARD_IMPEDANCE,
        )


def linear(coefficient: float) -> list[float]:
    """MuJoCo's springs and dampers are polynomials; this is a linear one."""
    return [coefficient, 0.0, 0.0]


def link(parent: mujoco.MjsBody, name: str, inertia_kg_m2: float = _LINK_INERTIA) -> mujoco.MjsBody:
    """A balanced body on the hinge's axis, without weight."""
    return parent.add_body(name=name, explicitinertial=True, mass=1e-6, inertia=[inertia_kg_m2] * 3)


def assemble(bench: BenchParameters, step_s: float) -> Assembly:
    """The effect-free twin: one hinge, one amplifier whose control is the wanted angle [rad]."""
    spec = mujoco.MjSpec()
    spec.modelname = "servosight twin"
    spec.option.timestep = step_s
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    spec.option.gravity = [0.0, -9.81, 0.0]
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    spec.option.disableflags |= (
        mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_ISLAND
    )
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_REFSAFE

    assembly = Assembly(bench, spec)
    horn = link(spec.worldbody, "horn")
    motor = assembly.hinge(horn, "motor")
    motor.armature = bench.armature_kg_m2
    motor.damping = linear(bench.damping_nms_rad)
    link(horn, "surface", bench.surface_inertia_kg_m2)
    assembly.amplifier(bench.loop_stiffness_nm_rad)
    return assembly
