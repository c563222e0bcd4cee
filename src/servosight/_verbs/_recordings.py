"""``ss.read``, ``ss.track`` and ``ss.simulate``: where recordings come from."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from servosight._verbs._given import names_of
from servosight._verbs._threads import one_algebra_thread
from servosight.models.base import silent

if TYPE_CHECKING:
    from servosight._verbs._given import Source
    from servosight.models.core import Recording, StageProgress
    from servosight.scenarios.produce import SimulatedRecording
    from servosight.scenarios.scenario import Scenario
    from servosight.sources import Tracking
    from servosight.tracking.core import CameraGeometry, Track


@one_algebra_thread
def read(
    source: Source,
    *,
    columns: Mapping[str, str] | None = None,
    unit: str | None = None,
    unit_scale: float | None = None,
    deg_per_us: float | None = None,
    neutral_us: float | None = None,
    part: int = 0,
    command: Path | str | None = None,
    angle_of: Literal["surface", "sensor"] | None = None,
    progress: StageProgress | None = None,
) -> Recording:
    """Read a recording: a folder, a CSV file, or a log of another program.

    A folder with a video and no angle is tracked first, which writes ``angle.csv`` into it.
    ``columns`` names the columns of another program's table by quantity (time, command, angle,
    sigma), with a unit where its header has none: ``{"time": "t:ms", "angle": "pos:rad"}``.
    ``unit`` is that of angle and command where no column has its own, ``unit_scale`` the degrees
    that show one unit of an output that is no angle. ``deg_per_us`` and ``neutral_us`` convert a
    command given as pulse width; ``part`` is which episode of a data set, from 0. ``command`` is a
    second table, on the same clock, in which the command stands. ``angle_of`` says whether the
    angle is that of the surface or the reading of the servo's own sensor. What the user should
    know about how a log was read is in the recording's ``notes``.
    ``progress(word, done, total)`` is called while a video is tracked. Raises InputError for
    whatever a recording cannot be.

    >>> import servosight as ss
    >>> from pathlib import Path
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
            part=part,
            command=None if command is None else Path(command),
            angle_of=angle_of,
        ),
        progress or silent,
    )
    hint = unit_hint(found)
    if hint is not None:
        warnings.warn(f"{found.name}: {hint}", stacklevel=2)
    return found


@one_algebra_thread
def track(
    source: Path | str,
    *,
    pivot: tuple[float, float] | None = None,
    template: tuple[int, int, int, int] | None = None,
    tip: tuple[float, float] | None = None,
    at_s: float | None = None,
    pick: int = 1,
    method: Literal["refine", "match", "marker"] = "refine",
    frame_table: Path | str | None = None,
    exposure_s: float | None = None,
    readout_s: float | None = None,
    camera: CameraGeometry | Path | str | None = None,
    beside: Track | None = None,
    textured: bool = False,
    marker_family: Literal["aruco", "apriltag"] = "aruco",
    marker_id: int | None = None,
    progress: StageProgress | None = None,
) -> Track:
    """Measure the angle of the moving part in a video, or in the video of a recording's folder.

    ``pivot`` x, y [px], ``template`` x, y, width, height [px] and ``tip`` x, y [px], a point of the
    part far from its pivot, say which part is meant, on the frame at ``at_s`` (the first one); each
    is enough by itself, and what is not given is found from the motion. ``pick`` takes another of
    the track's ``candidates``. ``method`` is refine (a fit to the pixels), match (template
    matching) or marker: the marker of ``marker_family`` with ``marker_id`` (default: the one that
    moves farthest). ``frame_table`` is a frames.csv with mid-exposure times, ``exposure_s`` and
    ``readout_s`` are the shutter's (found from motion blur where neither is given), ``camera`` is a
    calibration or the path of a camera.toml, and ``beside`` the track of another part of the same
    video: a second one is looked for beside it, with ``textured`` only one with texture.

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
    from servosight.sources import Part, Parts, Tracking

    marker = (marker_family, marker_id) if method == "marker" else None
    parts = Parts(Part(pivot, template, tip, at_s, pick))
    how = Tracking(parts, method, _geometry(camera), marker=marker)
    given: dict[str, Any] = {
        "frame_table": None if frame_table is None else Path(frame_table),
        "exposure_s": exposure_s,
        "readout_s": readout_s,
        "beside": beside,
        "textured": textured or None,
    }
    known = {name: value for name, value in given.items() if value is not None}
    return _tracked(Path(source), how, known, progress or silent)


def _geometry(camera: CameraGeometry | Path | str | None) -> CameraGeometry | None:
    """The calibration that was given, or that of the camera.toml at the path given."""
    if not isinstance(camera, Path | str):
        return camera
    from servosight.tracking.calibration import read_camera

    return read_camera(Path(camera))


def _tracked(
    place: Path, how: Tracking, known: Mapping[str, Any], progress: StageProgress
) -> Track:
    """The track of a video or, on the clock of its command, of the video in a folder."""
    from dataclasses import replace

    from servosight.models.io import inspect_folder
    from servosight.sources import follow_folder, measured

    if not place.is_dir():
        return next(measured(place, how, progress, **known))[0]
    tracks, offset = follow_folder(inspect_folder(place), how, progress, **known)
    return replace(tracks[0], time_s=tracks[0].time_s + offset.offset_s)


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
    if effect or set:
        scenario = with_effects(scenario, names_of(effect), set or {})
    return simulated(scenario if seed is None else replace(scenario, seed=seed))
