"""What an exporter is: it writes a file, says what it leaves out, and runs what it wrote.

An exporter stands in a file of its own, with a line in ``export/kinds.py``. ``export_model`` writes
the file to a temporary place, runs it there on a trial, compares it with the model and only then
moves it to where the user wants it.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from servosight.models.core import Actuator, Array, Recording
from servosight.models.effects import Effect


@dataclass(frozen=True, kw_only=True)
class ExportOptions:
    """What the user may choose; an exporter uses what concerns it.

    ``sample_time_s`` is that of a difference equation, or the time step of a simulator (None: the
    usual one there); ``transform`` is how an equation is sampled, one of
    ``models.plant.TRANSFORMS``. ``stiffness_nm_rad`` [N m/rad] is the stiffness of the position
    loop, by which a simulator of forces gets torques and inertia; no angle shows it.
    """

    sample_time_s: float | None = None
    transform: str = "tustin"
    stiffness_nm_rad: float = 1.0

    def step_s(self, usual_s: float) -> float:
        """The time step [s], ``usual_s`` where the user chose none."""
        return usual_s if self.sample_time_s is None else self.sample_time_s


@dataclass(frozen=True, kw_only=True)
class ExportRequest:
    """The model to write: ``name`` is an identifier of C and Python for it."""

    actuator: Actuator
    catalogue: Mapping[str, Effect]
    name: str = "servo"
    options: ExportOptions = field(default_factory=ExportOptions)


@dataclass(frozen=True, kw_only=True)
class Omission:
    """An effect that the target cannot express.

    ``approximation`` says what simpler thing stands in for it; None where it is left out.
    """

    effect: str
    approximation: str | None = None


@dataclass(frozen=True, kw_only=True)
class ExportTrial:
    """The command that an export is run on, from rest at ``start_deg``.

    ``recording`` has the command's rows and the times [s] at which the angle is wanted; its own
    angle may be that of a real servo, or zero.
    """

    recording: Recording
    start_deg: float


@dataclass(frozen=True, kw_only=True)
class Response:
    """The angle [deg] of the target at times [s], both (samples,), within those of the trial.

    ``notes`` are sentences on what the run showed.
    """

    time_s: Array
    angle_deg: Array
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Exporter:
    """One kind of export.

    ``target`` is the program that reads the file. ``write`` makes the file at a path, whose ending
    is the user's. ``omissions`` lists what the target cannot express. ``run`` runs the file at a
    path in the target. ``missing`` says why the target cannot be run here, None where it can.
    ``exact_deg`` is the largest difference from the model that is no error of the program; None
    where the target's model is simpler. ``notes`` are sentences that the user should read.
    """

    target: str
    write: Callable[[ExportRequest, Path], None]
    omissions: Callable[[ExportRequest], tuple[Omission, ...]]
    run: Callable[[ExportRequest, Path, ExportTrial], Response]
    missing: Callable[[], str | None] = lambda: None
    exact_deg: float | None = None
    notes: Callable[[ExportRequest], tuple[str, ...]] = lambda request: ()


def omitted(
    request: ExportRequest,
    expressed: Collection[str],
    approximations: Mapping[str, str] | None = None,
) -> tuple[Omission, ...]:
    """The model's effects that are not among ``expressed``, with what stands in for them."""
    instead = approximations or {}
    return tuple(
        Omission(effect=name, approximation=instead.get(name))
        for name in request.actuator.effects
        if name not in expressed
    )
