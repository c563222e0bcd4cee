"""The registry of exports: what ``--to`` accepts. A new one costs its file and a line here.

Nothing heavy is imported: the command's help is made from it.
"""

from __future__ import annotations

from dataclasses import dataclass

from servosight.models.base import InputError, Kind, did_you_mean, either


@dataclass(frozen=True)
class ExportKind:
    """A kind of file that a model becomes.

    ``home`` is the package that has the ``Exporter``, and its name there; ``summary`` says what is
    written; ``file`` is what the program recognises of its own: a table counts as the user's.
    """

    home: str
    exporter: str
    summary: str
    file: Kind = Kind.EXPORT


KINDS: dict[str, ExportKind] = {
    "csv": ExportKind(
        "discrete", "CSV", "table: the difference equation at a sample time", Kind.TABLE
    ),
    "header": ExportKind("discrete", "HEADER", "C header: the same coefficients"),
    "c": ExportKind("csource", "C", "C99 source: the whole model with all effects, step by step"),
    "fmu": ExportKind("fmu", "FMU3", "FMU of FMI 3.0: the whole model, binary and sources"),
    "fmu2": ExportKind("fmu", "FMU2", "FMU of FMI 2.0: the same"),
    "jsbsim": ExportKind("autopilots", "JSBSIM", "JSBSim: a system file in XML"),
    "ardupilot": ExportKind("autopilots", "ARDUPILOT", "ArduPilot SITL: SIM_SERVO parameters"),
    "mjcf": ExportKind("mjcf", "MJCF", "MuJoCo: a model of the servo"),
    "urdf": ExportKind("mjcf", "URDF", "URDF: a joint with limits and friction, for Gazebo"),
    "sdf": ExportKind("mjcf", "SDF", "SDF: the same with its position controller, for Gazebo"),
    "control": ExportKind("linear", "CONTROL", "Python: python-control transfer functions"),
}
"""By the word behind ``--to``, in the order of the help."""


def kind_named(name: str) -> ExportKind:
    """The kind of that name; InputError with the nearest name for another."""
    if name not in KINDS:
        raise InputError(
            f"{either('to', '--to')} is {name}, no such export{did_you_mean(name, KINDS)}; "
            f"expected one of {', '.join(KINDS)}: see `servosight export --help`"
        )
    return KINDS[name]
