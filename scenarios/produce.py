"""From a scenario to a recording's folder, with its truth beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from servosight.models.core import (
    Camera,
    FrameProgress,
    Recording,
    check_folder,
    new_folder,
    write_text,
)
from servosight.models.io import FILES, save_recording, table_text, write_angle
from servosight.scenarios.camera_settings import filming_tables
from servosight.scenarios.scenario import Scenario, check_scenario
from servosight.sim.bench import Trajectory
from servosight.sim.run import angle_recording, run

VIDEO = "video.mkv"
TRUTH = "truth.toml"
TRUE_ANGLE = "truth_angle.csv"
"""Mean angles over the exposures without noise, for tests that score a tracker."""
TRUE_FRAMES = "truth_frames.csv"
"""What is true of each frame of a video; docs/camera.md lists the columns."""
DRAWN = ("track_overlay.mp4", "track_sheet.png")
OURS = (*FILES, VIDEO, "frames.csv", "track.toml", *DRAWN, TRUTH, TRUE_ANGLE, TRUE_FRAMES)
KNOWN = ("rate_hz", "exposure_s", "readout_s", "width", "height")


@dataclass(frozen=True, repr=False)
class SimulatedRecording(Recording):
    """A recording of the twin; ``truth`` has the contents of its truth.toml, for scoring."""

    truth: Mapping[str, Any] = field(default_factory=dict)


def simulated(scenario: Scenario) -> SimulatedRecording:
    """Run ``scenario`` and measure its angle, without any file or video.

    Raises InputError for a value of the scenario that makes no sense.
    """
    check_scenario(scenario, "scenario")
    trajectory = run(scenario.servo.bench(), scenario.effects, scenario.excitation())
    noisy = angle_recording(
        trajectory, _camera(scenario), scenario.noise_deg, _stream(scenario, 0), name="simulated"
    )
    own = {f.name: getattr(noisy, f.name) for f in fields(noisy)}
    return SimulatedRecording(**own, truth=_truth(scenario))


def produce(
    scenario: Scenario, folder: Path, progress: FrameProgress | None = None, *, force: bool = False
) -> Trajectory:
    """Run ``scenario`` and write ``folder`` completely or not at all; returns the true trajectory.

    With a video there is no angle.csv: it is tracked first. ``progress`` receives the frames done
    and the number of all frames. Raises InputError where ``folder`` is not empty, unless it was
    simulated before (it then holds truth.toml) or ``force`` is given, and in any case where it
    holds what is not a recording's.
    """
    check_folder(folder, OURS, sign=TRUTH, force=force)
    trajectory = run(scenario.servo.bench(), scenario.effects, scenario.excitation())
    camera = _camera(scenario)
    exact = angle_recording(trajectory, camera, 0.0, 0, name=folder.name)
    noisy = angle_recording(
        trajectory, camera, scenario.noise_deg, _stream(scenario, 0), name=folder.name
    )
    with new_folder(folder, OURS, sign=TRUTH, force=force) as fresh:
        save_recording(noisy, fresh, extra=_known(scenario))
        truth = _truth(scenario)
        if scenario.video:
            (fresh / "angle.csv").unlink()
            truth["video"] = _render(scenario, camera, trajectory, fresh, progress)
        write_angle(fresh / TRUE_ANGLE, exact.time_s, exact.angle_deg, None)
        write_text(fresh / TRUTH, tomli_w.dumps(truth))
    return trajectory


def _camera(scenario: Scenario) -> Camera:
    """The scenario's camera, whose clock is drawn by the scenario's seed as well."""
    return replace(scenario.camera, clock_seed=_stream(scenario, 2) + scenario.camera.clock_seed)


def _truth(scenario: Scenario) -> dict[str, Any]:
    """The hidden effects and parameters, and the scenario to repeat them."""
    return {
        "format": 1,
        "effects": list(scenario.effects),
        "parameters": scenario.truth(),
        "scenario": _settings(scenario),
    }


def _render(
    scenario: Scenario,
    camera: Camera,
    trajectory: Trajectory,
    folder: Path,
    progress: FrameProgress | None,
) -> dict[str, Any]:
    """Render the video; returns the truth that the tracker has to find."""
    from servosight.sim.film import render_video

    frames = render_video(
        trajectory,
        camera,
        folder / VIDEO,
        seed=_stream(scenario, 1),
        settings=scenario.filming,
        progress=progress,
    )
    columns = frames.columns()
    write_text(folder / TRUE_FRAMES, table_text(list(columns), list(columns.values())))
    truth: dict[str, Any] = {
        "pivot_px": list(frames.pivot_px),
        "horn_px": list(frames.horn_px),
        "focal_px": frames.focal_px,
        "principal_px": list(frames.principal_px),
    }
    if frames.led_on_s is not None:
        truth["led_on_s"] = frames.led_on_s
    return truth


def _stream(scenario: Scenario, number: int) -> int:
    """A seed for one source of noise, independent of the others and of the command's."""
    return int(np.random.SeedSequence([scenario.seed, 2, number]).generate_state(1)[0])


def _known(scenario: Scenario) -> dict[str, Any]:
    """What recording.toml says of the camera: the data of its data sheet, and its clock.

    Times in the twin's video count from its first frame, which starts with the command's clock.
    """
    camera = {name: getattr(scenario.camera, name) for name in KNOWN}
    return {"video_offset_s": 0.0, "camera": camera} if scenario.video else {"camera": camera}


def _settings(scenario: Scenario) -> dict[str, Any]:
    """The scenario as the table of its file."""
    table = asdict(scenario)
    if scenario.camera.pivot_px is None:
        del table["camera"]["pivot_px"]
    del table["filming"]
    return {**table, **filming_tables(scenario.filming)}
