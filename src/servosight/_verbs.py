"""The verbs of ``import servosight as ss``: thin, and each with its defaults.

A recording is given as a ``Recording`` or as the path of one; several as a sequence of either, or
as one. What a verb needs is imported when it is called.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, overload

if TYPE_CHECKING:
    from servosight.diagnose import Comparison, Diagnosis
    from servosight.identify.fit import Fit
    from servosight.models.core import Actuator, Recording, StageProgress, Table
    from servosight.models.effects import Effect, EffectInfo
    from servosight.scenarios.produce import SimulatedRecording
    from servosight.scenarios.scenario import Scenario
    from servosight.tracking.core import CameraGeometry, Track

    Source: TypeAlias = Recording | Path | str
    Sources: TypeAlias = Source | Sequence[Source]
    Model: TypeAlias = Fit | Diagnosis | Comparison | Actuator | Path | str


def read(
    source: Source,
    *,
    columns: Mapping[str, str] | None = None,
    unit: str | None = None,
    unit_scale: float | None = None,
    deg_per_us: float | None = None,
    neutral_us: float | None = None,
    progress: StageProgress | None = None,
) -> Recording:
    """Read a recording: a folder, a CSV file, or a log of another program.

    A folder with a video and no angle is tracked first, which writes ``angle.csv`` into it.
    ``columns`` names the columns of another program's table by quantity (time, command, angle,
    sigma), with a unit where it is not s or deg: ``{"time": "t:ms", "angle": "pos:rad"}``.
    ``unit`` is that of angle and command where no column has its own, ``unit_scale`` the degrees
    that show one unit of an output that is no angle. ``deg_per_us`` and ``neutral_us`` convert a
    command given as pulse width. ``progress(word, done, total)`` is called while a video is
    tracked. Raises InputError for whatever a recording cannot be.

    >>> import servosight as ss
    >>> rows = ["time_s,command_deg,angle_deg"]
    >>> rows += [f"{0.01 * i:.2f},{10 * (i // 50 % 2)},{9.9 * (i // 50 % 2)}" for i in range(200)]
    >>> _ = Path("run7.csv").write_text("\\n".join(rows))
    >>> ss.read("run7.csv")
    <Recording run7: 200 samples over 1.99 s, moved 9.90 deg>
    """
    from servosight.sources import Options, read, unit_hint

    found = read(
        source,
        Options(
            columns=columns or {},
            unit=unit,
            unit_scale=unit_scale,
            deg_per_us=deg_per_us,
            neutral_us=neutral_us,
        ),
        progress or _silent,
    )
    hint = unit_hint(found)
    if hint is not None:
        warnings.warn(f"{found.name}: {hint}", stacklevel=2)
    return found


def track(
    source: Path | str,
    *,
    pivot: tuple[float, float] | None = None,
    template: tuple[int, int, int, int] | None = None,
    method: Literal["refine", "match", "marker"] = "refine",
    frame_table: Path | str | None = None,
    exposure_s: float | None = None,
    readout_s: float | None = None,
    camera: CameraGeometry | Path | str | None = None,
    beside: Track | None = None,
    marker_family: Literal["aruco", "apriltag"] = "aruco",
    marker_id: int | None = None,
    progress: StageProgress | None = None,
) -> Track:
    """Measure the angle of the moving part in a video, or in the video of a recording's folder.

    ``pivot`` x, y [px] and ``template`` x, y, width, height [px] on the first frame are found from
    the motion where they are not given. ``method`` is refine (a fit to the pixels), match (template
    matching) or marker: the marker of ``marker_family`` with ``marker_id`` (default: the one that
    moves farthest). ``frame_table`` is a frames.csv with mid-exposure times, ``exposure_s`` and
    ``readout_s`` are the shutter's (found from motion blur where neither is given), ``camera`` is a
    calibration or the path of a camera.toml, and ``beside`` the track of another part of the same
    video: a second one is looked for beside it.

    A recording's folder gives exposure, camera and the clock of its command, on which the track's
    times then are; what is given here goes before it. Nothing is written into it (``read`` does
    that). ``progress(word, done, total)`` is called as it goes. Raises InputError where the video
    cannot be read or nothing in it turns.

    >>> import servosight as ss
    >>> ss.track("fin.mp4")
    Traceback (most recent call last):
        ...
    servosight.models.base._errors.InputError: fin.mp4: ...
    """
    from dataclasses import replace

    from servosight.models.io import inspect_folder
    from servosight.sources import Part, Parts, Tracking, follow_folder, measure

    if isinstance(camera, Path | str):
        from servosight.tracking.calibration import read_camera

        camera = read_camera(Path(camera))
    place = Path(source)
    marker = (marker_family, marker_id) if method == "marker" else None
    how = Tracking(Parts(Part(pivot, template)), method, camera, marker=marker)
    given: dict[str, Any] = {
        "frame_table": None if frame_table is None else Path(frame_table),
        "exposure_s": exposure_s,
        "readout_s": readout_s,
        "beside": beside,
    }
    known = {name: value for name, value in given.items() if value is not None}
    if not place.is_dir():
        return measure(place, how, progress or _silent, **known)[0]
    tracks, offset = follow_folder(inspect_folder(place), how, progress or _silent, **known)
    return replace(tracks[0], time_s=tracks[0].time_s + offset.offset_s)


def identify(
    recordings: Sources,
    effects: Sequence[str] = (),
    *,
    method: str = "combination",
    seed: int = 0,
    tolerance: float | None = None,
    plugins: Sequence[Path | str] = (),
) -> Fit:
    """Fit k, T, xi, bias and the parameters of ``effects`` to recordings, jointly.

    ``method`` is combination (genetic operators and swarm), ga, pso or gradient; ``seed`` that of
    its random numbers. ``tolerance`` [deg] is what no model need reach (default 0.05 % of the moved
    range). ``plugins`` are files with effects of your own, which are run. Raises InputError for a
    recording, an effect or a method that is none.

    >>> import servosight as ss
    >>> fit = ss.identify(ss.simulate(seed=3), method="gradient")
    >>> sorted(fit.parameters)
    ['T', 'bias', 'k', 'xi']
    """
    from servosight.identify.fit import identify, with_information
    from servosight.sources import read_all

    known, given = _catalogue(plugins), read_all(recordings)
    fit = identify(given, effects, catalogue=known, method=method, seed=seed, tolerance=tolerance)
    return with_information(fit, given, known).remember(given, known)


def compare(
    model: Model,
    recordings: Sources,
    *,
    tolerance: float | None = None,
    plugins: Sequence[Path | str] = (),
) -> Comparison:
    """Simulate a model on recordings and say where it fails.

    ``model`` is a fit, a diagnosis (its last step), an actuator, or the path of a model card. The
    physical parameters stay as they are; bias and initial state are found on each recording.

    >>> import servosight as ss
    >>> recording = ss.simulate(effect="backlash", set={"backlash.gap": 1.5}, seed=3)
    >>> fit = ss.identify(recording, method="gradient")
    >>> ss.compare(fit, recording).explained
    False
    """
    from servosight.diagnose import compare
    from servosight.sources import read_all

    known, given = _catalogue(plugins), read_all(recordings)
    found = compare(_actuator(model, known), given, catalogue=known, tolerance=tolerance)
    return found.remember(given, known)


def diagnose(
    recordings: Sources,
    *,
    validate: Sources = (),
    test: Sources = (),
    auto: bool = True,
    tolerance: float | None = None,
    plugins: Sequence[Path | str] = (),
    progress: StageProgress | None = None,
) -> Diagnosis:
    """Find out which physical effects the linear model misses.

    The fit sees ``recordings``; which effects enter is decided on ``validate``; ``test`` is looked
    at once, for the report. Without them, blocks of one second are held out. With ``auto`` the best
    effect is added and fitted again until the error is at the floor or nothing helps; without, the
    candidates of the first step are ranked. ``tolerance`` [deg] is what no model need reach
    (default 0.05 % of the moved range). ``progress(word, done, total)`` is called as it goes.

    >>> import servosight as ss
    >>> recording = ss.simulate(effect="backlash", set={"backlash.gap": 1.5}, seed=3)
    >>> why = ss.diagnose(recording)
    >>> why.effects
    ('backlash',)
    """
    from servosight.diagnose import diagnose
    from servosight.sources import read_all

    known = _catalogue(plugins)
    fitted, validating, testing = read_all(recordings), read_all(validate), read_all(test)
    found = diagnose(
        fitted,
        validating,
        testing,
        catalogue=known,
        auto=auto,
        tolerance=tolerance,
        progress=progress or _silent,
    )
    return found.remember([*fitted, *validating, *testing], known)


def add(
    model: Model, effect: str, recordings: Sources, *, plugins: Sequence[Path | str] = ()
) -> Fit:
    """The model with one more effect, all parameters fitted to the recordings jointly.

    Raises InputError where the model has that effect already, or nobody knows it.

    >>> import servosight as ss
    >>> recording = ss.simulate(effect="backlash", set={"backlash.gap": 1.5}, seed=3)
    >>> better = ss.add(ss.identify(recording, method="gradient"), "backlash", recording)
    >>> round(better.parameters["backlash.gap"].value, 1)
    1.5
    """
    from servosight.diagnose import add
    from servosight.sources import read_all

    known, given = _catalogue(plugins), read_all(recordings)
    return add(_actuator(model, known), effect, given, catalogue=known).remember(given, known)


def simulate(
    scenario: Scenario | Path | str | None = None,
    *,
    effect: str | Sequence[str] = (),
    set: Mapping[str, float] | None = None,
    seed: int | None = None,
) -> SimulatedRecording:
    """A recording of the simulated servo (MuJoCo), with its ``truth``.

    ``scenario`` is a scenario or the path of its TOML file (default: the standard one), ``effect``
    what is hidden in the servo, ``set`` parameters such as ``{"backlash.gap": 1.5, "T": 0.03}``,
    ``seed`` that of command and noise. Raises InputError for unknown names and for values out of
    bounds.

    >>> import servosight as ss
    >>> recording = ss.simulate(effect="backlash", set={"backlash.gap": 1.5}, seed=3)
    >>> recording.truth["effects"]
    ['backlash']
    """
    from dataclasses import replace

    from servosight.scenarios.produce import simulated
    from servosight.scenarios.scenario import Scenario, with_effects

    if scenario is None:
        scenario = Scenario()
    elif not isinstance(scenario, Scenario):
        scenario = Scenario.load(Path(scenario))
    if seed is not None:
        scenario = replace(scenario, seed=seed)
    hidden = [effect] if isinstance(effect, str) else list(effect)
    if hidden or set:
        scenario = with_effects(scenario, hidden, set or {})
    return simulated(scenario)


@overload
def effects(identifier: str, *, plugins: Sequence[Path | str] = ()) -> EffectInfo: ...
@overload
def effects(
    identifier: None = None, *, plugins: Sequence[Path | str] = ()
) -> Table[EffectInfo]: ...
def effects(
    identifier: str | None = None, *, plugins: Sequence[Path | str] = ()
) -> Table[EffectInfo] | EffectInfo:
    """The catalogue of effects as a table, or all about one of them.

    >>> import servosight as ss
    >>> ss.effects("backlash").place
    'transmission'
    >>> len(ss.effects()) >= 20
    True
    """
    from servosight.models.core import Table
    from servosight.models.effects import effect_info, select

    known = _catalogue(plugins)
    if identifier is None:
        return Table(effect_info(effect) for effect in known.values())
    (name,) = select(known, [identifier])
    return effect_info(known[name])


def load(path: Path | str) -> Any:
    """Read back what ``save`` wrote: a fit, comparison, diagnosis or track, an actuator's card.

    A folder or a CSV file is read as a recording.

    >>> import servosight as ss
    >>> ss.identify(ss.simulate(seed=3), method="gradient").save("fit.json")
    >>> type(ss.load("fit.json")).__name__
    'Fit'
    """
    from servosight.models.core import Actuator, InputError, read_json

    place = Path(path)
    if place.suffix == ".toml":
        return Actuator.load(place, _catalogue(()))
    if place.is_dir() or place.suffix != ".json":
        return read(place)
    kind = read_json(place).get("type")
    if kind not in _RESULTS:
        raise InputError(
            f"{place}: key type is {kind!r}, expected one of {', '.join(_RESULTS)}; save the "
            f"result again"
        )
    home, name = _RESULTS[kind]
    return getattr(import_module(home), name).load(place)


_RESULTS = {
    "fit": ("servosight.identify.fit", "Fit"),
    "comparison": ("servosight.diagnose", "Comparison"),
    "diagnosis": ("servosight.diagnose", "Diagnosis"),
    "track": ("servosight.tracking.core", "Track"),
}
"""Where the class of each result is, by the ``type`` in its JSON."""


def _silent(stage: str, done: int, total: int | None = None) -> None:
    """Nobody asked for progress."""


def _catalogue(plugins: Sequence[Path | str]) -> Mapping[str, Effect]:
    from servosight.models.effects import catalogue

    return catalogue([Path(plugin) for plugin in plugins])


def _actuator(model: Model, known: Mapping[str, Effect]) -> Actuator:
    """The actuator that a model is, or has."""
    from servosight.models.core import Actuator

    if isinstance(model, Path | str):
        return Actuator.load(Path(model), known)
    return model if isinstance(model, Actuator) else model.actuator
