"""Write a model, run what was written, compare it with the model, then put it in its place."""

from __future__ import annotations

import re
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path

import numpy as np

from servosight.export.core._contract import (
    Exporter,
    ExportOptions,
    ExportRequest,
    ExportTrial,
    Response,
)
from servosight.export.core._result import ExportResult, OmittedEffect
from servosight.export.core._trial import model_angle, trial_of
from servosight.export.kinds import kind_named
from servosight.models.core import Actuator, Array, InputError, Recording, Table, either, new_file
from servosight.models.effects import Effect, catalogue
from servosight.models.plant import TRANSFORMS

REFIT_SHARE = 0.05
"""Advice is given where the target differs by so much of the moved range (rms)."""
LARGEST_DEG = 1e6
"""No servo turns as far on a trial."""
SAMPLE_TIME_S = (1e-5, 1.0)
"""Shortest and longest sample time [s]."""
STIFFNESS_NM_RAD = (1e-3, 1e6)
"""Softest and stiffest position loop: MuJoCo wants inertia above 1e-15 kg m^2."""


def export_model(
    actuator: Actuator,
    to: str,
    output: Path,
    *,
    effects: Mapping[str, Effect] | None = None,
    options: ExportOptions | None = None,
    on: Recording | None = None,
) -> ExportResult:
    """Write ``actuator`` as the kind ``to`` (one of ``KINDS``) to ``output``.

    The file appears when it has been run in its target, where that is installed, on the recording
    ``on`` or a standard command. ``effects`` is the catalogue (default: the built-in one). Raises
    InputError for a kind or an option that is none, RuntimeError where an export that must equal
    the model does not: then nothing is written.
    """
    home = kind_named(to)
    options = _checked(options or ExportOptions())
    exporter: Exporter = getattr(import_module(f"servosight.export.{home.home}"), home.exporter)
    request = ExportRequest(
        actuator=actuator,
        catalogue=catalogue() if effects is None else effects,
        name=identifier(output.stem),
        options=options,
    )
    trial = trial_of(actuator, on)
    whole = _bounded(model_angle(request, trial))
    reason = exporter.missing()
    with new_file(output) as place:
        exporter.write(request, place)
        response = None if reason else exporter.run(request, place, trial)
        return _result(
            to, output, exporter, request, trial, whole, response, reason, on is not None
        )


def _bounded(angle: Array) -> Array:
    """The model's angle; InputError where it runs away, as with a current limit that drives."""
    if not np.all(np.abs(angle) < LARGEST_DEG):
        raise InputError(
            f"the model's own angle grows beyond {LARGEST_DEG:g} deg on the trial, expected a "
            f"model that stays within it; correct its card"
        )
    return angle


def identifier(text: str) -> str:
    """A name that C and Python accept, from a file's name.

    >>> identifier("fin-2 left"), identifier("9g"), identifier("")
    ('fin_2_left', 'servo_9g', 'servo')
    """
    word = re.sub(r"\W+", "_", text, flags=re.ASCII).strip("_").lower()
    return word if word[:1].isalpha() else f"servo_{word}".rstrip("_")


def _checked(options: ExportOptions) -> ExportOptions:
    low, high = SAMPLE_TIME_S
    if options.sample_time_s is not None and not low <= options.sample_time_s <= high:
        raise InputError(
            f"{either('sample_time_s', '--sample-time')} is {options.sample_time_s:g}, expected "
            f"{low:g} to {high:g} s; give the period of your control loop"
        )
    low, high = STIFFNESS_NM_RAD
    if not low <= options.stiffness_nm_rad <= high:
        raise InputError(
            f"{either('stiffness_nm_rad', '--stiffness')} is {options.stiffness_nm_rad:g}, "
            f"expected {low:g} to {high:g} N m/rad; give the torque for one radian of position "
            f"error"
        )
    if options.transform not in TRANSFORMS:
        raise InputError(
            f"{either('transform', '--transform')} is {options.transform}, expected one of "
            f"{', '.join(TRANSFORMS)}; choose one of these methods of sampling"
        )
    return options


def _result(
    to: str,
    output: Path,
    exporter: Exporter,
    request: ExportRequest,
    trial: ExportTrial,
    whole: Array,
    response: Response | None,
    reason: str | None,
    measured: bool,
) -> ExportResult:
    rows = Table(
        OmittedEffect(
            one.effect,
            one.approximation,
            rms(model_angle(request, trial, without=one.effect) - whole),
        )
        for one in exporter.omissions(request)
    )
    difference = None if response is None else _difference(request, trial, response)
    largest = None if difference is None else float(np.max(np.abs(difference)))
    if exporter.exact_deg is not None and largest is not None and largest > exporter.exact_deg:
        raise RuntimeError(
            f"the {to} export differs from the model by {largest:.3g} deg, at most "
            f"{exporter.exact_deg:.3g} expected; nothing was written"
        )
    errors = _errors(request, trial, response, difference) if measured else (None, None)
    return ExportResult(
        kind=to,
        file=str(output),
        target=exporter.target,
        trial=trial.recording.name,
        samples=int(trial.recording.time_s.size),
        difference_rms_deg=None if difference is None else rms(difference),
        difference_max_deg=largest,
        model_rmse_deg=errors[0],
        target_rmse_deg=errors[1],
        not_run=reason,
        omissions=rows,
        notes=(
            *exporter.notes(request),
            *(() if response is None else response.notes),
            *_refit_note(request, exporter.target, rows, difference, whole),
            *_input_note(request),
        ),
    )


def _input_note(request: ExportRequest) -> tuple[str, ...]:
    """What an export does not take: its one input is the command."""
    named = [name for name in request.actuator.effects if request.catalogue[name].needs_disturbance]
    return tuple(
        f"{name}: an export has no input for a known disturbance, so it answers as where there is "
        f"none"
        for name in named
    )


def _refit_note(
    request: ExportRequest,
    target: str,
    omissions: Table[OmittedEffect],
    difference: Array | None,
    whole: Array,
) -> tuple[str, ...]:
    """Advice where what is left out matters: k, T and xi of a model without it differ."""
    absent = {one.effect for one in omissions if one.approximation is None}
    if difference is None or not absent or rms(difference) < REFIT_SHARE * float(np.ptp(whole)):
        return ()
    left = [name for name in request.actuator.effects if name not in absent]
    words = f" --effects {','.join(left)}" if left else ""
    return (
        f"what {target} lacks is a large part of this model; a model fitted without it comes "
        f"closer: export that of `servosight identify REC{words}`",
    )


def _difference(request: ExportRequest, trial: ExportTrial, response: Response) -> Array:
    """Target minus model at the target's own times [deg], (samples,)."""
    if not np.all(np.isfinite(response.angle_deg)):
        raise RuntimeError("the export gives angles that are not finite; nothing was written")
    return response.angle_deg - model_angle(request, trial, time_s=response.time_s)


def _errors(
    request: ExportRequest, trial: ExportTrial, response: Response | None, difference: Array | None
) -> tuple[float, float | None]:
    """Rms error of model and target against the measured angle [deg].

    The target's angle at the recording's times is the model's, averaged over the exposure, plus the
    difference between the two, which is small and therefore safe to interpolate.
    """
    recording = trial.recording
    model = model_angle(request, trial, averaged=True)
    error = model - recording.angle_deg
    if response is None or difference is None:
        return rms(error), None
    between = np.interp(recording.time_s, response.time_s, difference)
    return rms(error), rms(error + between)


def rms(values: Array) -> float:
    """Root mean square, of values cut to what an angle can be."""
    return float(np.sqrt(np.mean(np.square(np.clip(values, -LARGEST_DEG, LARGEST_DEG)))))
