"""Simulate the twin, and sample its angle like a camera of known timing and noise."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import mujoco
import numpy as np
from scipy.interpolate import CubicHermiteSpline

from servosight.models.core import Array, Camera, InputError, Recording
from servosight.models.excitation import Excitation
from servosight.sim.assembled import longest_step_s, put_to_rest, with_effects
from servosight.sim.bench import GRID_S, BenchParameters, Trajectory
from servosight.sim.effects import TWIN_EFFECTS, Polyline, Twin, resolve
from servosight.sim.linkage import Linkage
from servosight.sim.stepping import ActiveEffects, Stepper

_UNSTABLE = (
    mujoco.mjtWarning.mjWARN_BADQPOS,
    mujoco.mjtWarning.mjWARN_BADQVEL,
    mujoco.mjtWarning.mjWARN_BADQACC,
)

_SAME_S = 1e-8  # instants closer than this are one

SETTLE = 25.0
"""Time constants for which the first command is applied before the record begins."""


def run(
    bench: BenchParameters,
    effects: Mapping[str, Mapping[str, float]],
    excitation: Excitation,
) -> Trajectory:
    """Simulate ``bench`` with hidden ``effects`` (id to parameters) under a held command.

    The record runs from the first row of the command to the last, on a grid of 0.1 ms. Raises
    InputError for effects or parameters that the twin does not have.
    """
    chosen = [(TWIN_EFFECTS[name], values) for name, values in resolve(effects).items()]
    step_s = longest_step_s(bench.T, (effect for effect, _ in chosen))
    assembly = with_effects(bench, chosen, step_s)
    line = zero_order_hold(excitation)
    for effect, values in chosen:
        line = effect.command(line, values)
    start = float(excitation.time_s[0])
    settled = start - SETTLE * bench.T
    rows = _disturbance_rows(excitation)
    try:
        twin = Twin(assembly, settled, rows)
    except ValueError as error:  # from MuJoCo's compiler
        raise _impossible(chosen, " ".join(str(error).split())) from None

    points = math.ceil(excitation.duration_s / GRID_S - 1e-6) + 1
    grid = start + GRID_S * np.arange(points, dtype=np.float64)
    knots = np.concatenate([line[0], rows[0]])
    edges = steps_between(settled, knots, float(grid[-1]), step_s)
    middles = 0.5 * (edges[1:] + edges[:-1])
    wanted = np.radians(bench.gain * np.interp(middles, *line) + bench.bias_deg)

    surface = put_to_rest(twin, assembly, float(wanted[0]))
    with _quiet():
        angles, speeds = _integrate(twin, chosen, edges, wanted)
    if any(twin.data.warning[kind].number for kind in _UNSTABLE) or not np.isfinite(angles).all():
        raise _impossible(chosen, "the motion grows without bound")

    def on_grid(hinges: list[int]) -> Array:
        both = (np.degrees(x[:, hinges].sum(axis=1)) for x in (angles, speeds))
        return np.asarray(CubicHermiteSpline(edges, *both)(grid))

    behind = on_grid(surface)
    for effect, values in chosen:
        behind = effect.output(behind, values)
    return Trajectory(
        grid,
        on_grid([twin.sensor]),
        behind,
        excitation.at(grid),
        excitation,
        _linkage(chosen),
    )


def _linkage(chosen: ActiveEffects) -> Linkage | None:
    """What joins horn and surface, where an effect says it."""
    shapes = [effect.linkage(values) for effect, values in chosen if effect.linkage is not None]
    return shapes[-1] if shapes else None


def _disturbance_rows(excitation: Excitation) -> Polyline:
    """Times and values of the known disturbance; one row of zero where there is none."""
    known = excitation.disturbance
    if known is None:
        return excitation.time_s[:1], np.zeros(1)
    (values,) = known.values.values()
    return known.time_s, values


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep MuJoCo from printing its warnings, and from writing them to a file."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def _impossible(chosen: ActiveEffects, reason: str) -> InputError:
    values = ", ".join(f"{e.id}.{key} = {v:g}" for e, set_ in chosen for key, v in set_.items())
    return InputError(
        f"the servo cannot be simulated with {values or 'these values'} ({reason}); expected those "
        f"of a real servo, as `servosight effects` lists them: correct them"
    )


def _integrate(
    twin: Twin, chosen: ActiveEffects, edges_s: Array, wanted: Array
) -> tuple[Array, Array]:
    """Angles and speeds [rad, rad/s] of all hinges at ``edges_s`` (n,), each (n, hinges)."""
    stepper = Stepper(twin, chosen)
    angles = np.empty((edges_s.size, twin.model.nq))
    speeds = np.empty((edges_s.size, twin.model.nv))
    angles[0], speeds[0] = stepper.position, stepper.speed
    for n, (angle, width) in enumerate(
        zip(wanted.tolist(), np.diff(edges_s).tolist(), strict=True), start=1
    ):
        stepper.advance(angle, width)
        angles[n], speeds[n] = stepper.position, stepper.speed
    return angles, speeds


def zero_order_hold(excitation: Excitation) -> Polyline:
    """Knots of the command held between its rows (zero-order): flat pieces with jumps between."""
    return (
        np.repeat(excitation.time_s, 2)[1:].astype(np.float64),
        np.repeat(excitation.command_deg, 2)[:-1].astype(np.float64),
    )


def steps_between(start_s: float, knots_s: Array, end_s: float, longest_s: float) -> Array:
    """Edges of steps of at most ``longest_s`` from start to end, with all knots among them.

    Rounding a jump of the command to a grid would be a delay of a fraction of a step; averaging
    the command over the step would pass the wrong torque through a dead band or a limit.
    """
    inside = np.unique(knots_s[(knots_s > start_s + _SAME_S) & (knots_s < end_s - _SAME_S)])
    inside = inside[np.diff(inside, prepend=-np.inf) > _SAME_S]
    bounds = np.concatenate([[start_s], inside, [end_s]])
    counts = np.ceil(np.diff(bounds) / longest_s - 1e-6).astype(int)
    ends = np.concatenate([[0], np.cumsum(counts)])
    return np.asarray(np.interp(np.arange(ends[-1] + 1), ends, bounds))


def angle_recording(
    trajectory: Trajectory,
    camera: Camera,
    noise_deg: float,
    seed: int,
    *,
    name: str = "twin",
    with_sigma: bool = True,
) -> Recording:
    """The surface's mean angle over each exposure, with Gaussian noise of ``noise_deg`` rms.

    ``with_sigma`` False leaves the noise to be estimated, as with an encoder's log.
    """
    duration_s = trajectory.duration_s - camera.readout_s  # the last row ends within the record
    starts = camera.frame_starts(duration_s, float(trajectory.time_s[0]))
    time_s = camera.mid_exposure(starts)
    noise = noise_deg * np.random.default_rng(seed).standard_normal(time_s.size)
    return Recording(
        name=name,
        command_time_s=np.asarray(trajectory.excitation.time_s, dtype=np.float64),
        command_deg=np.asarray(trajectory.excitation.command_deg, dtype=np.float64),
        time_s=time_s,
        angle_deg=trajectory.mean_angle(time_s, camera.exposure_s) + noise,
        sigma_deg=np.full(time_s.size, noise_deg) if with_sigma and noise_deg > 0.0 else None,
        exposure_s=camera.exposure_s,
        signals=trajectory.excitation.disturbance,
    )
