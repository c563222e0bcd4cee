"""A trial of the hidden-effect benchmark through the video: filmed and tracked."""

from __future__ import annotations

import tempfile
from pathlib import Path

import servosight as ss
from servosight.models.core import Recording

from .draw import TrialSetup

VIDEO = "film.mkv"


def film(setup: TrialSetup) -> Recording:
    """Angle and sigma that the tracker measures in the trial's video, given only the exposure time.

    The first frame of the film is at time 0 of the command. Frames that did not measure the angle
    are left out, as in ``angle.csv``.
    """
    from servosight.sim.film import render_video

    with tempfile.TemporaryDirectory() as folder:
        video = Path(folder) / VIDEO
        render_video(setup.trajectory(), setup.camera, video, seed=setup.stream(8))
        found = ss.track(video, exposure_s=setup.camera.exposure_s)
    seen = found.measured
    return Recording(
        name=setup.name,
        command_time_s=setup.excitation.time_s,
        command_deg=setup.excitation.command_deg,
        time_s=found.time_s[seen],
        angle_deg=found.angle_deg[seen],
        sigma_deg=found.sigma_deg[seen],
        exposure_s=setup.camera.exposure_s,
        shared_deg=None if found.shared_deg is None else found.shared_deg[seen],
    )
