"""Video in, angle and its sigma out."""

from __future__ import annotations

from pathlib import Path

from servosight.models.core import FrameProgress
from servosight.tracking.core import Track, TrackOptions
from servosight.tracking.methods import beside_what_turns_evenly, method_of
from servosight.tracking.video import Film, open_film


def track(
    video: Path | str,
    options: TrackOptions | None = None,
    *,
    progress: FrameProgress | None = None,
) -> Track:
    """Measure the angle of the moving part in every frame of a video.

    ``options`` say what is given (pivot, exposure, a calibrated camera) and by which method;
    ``progress`` is called with the numbers of frames done and of all. The video is streamed:
    memory does not grow with its length. Raises ``InputError``, one sentence, for a video that
    cannot be read or tracked.

    The angle is relative to the first frame [deg], counter-clockwise positive as seen; times are
    mid-exposure of the middle row [s]. ``refine`` reaches the bound of Robinson and Milanfar
    (2004) to some 10 % where the part has texture (docs/tracking.md).

    >>> found = track("fin.mkv", TrackOptions(exposure_s=0.002))  # doctest: +SKIP
    >>> found.save("angle.csv")  # doctest: +SKIP
    """
    options = options if options is not None else TrackOptions()
    method_of(options.method)  # before the video is read through
    return track_film(open_film(Path(video), options), options, progress)


def track_film(film: Film, options: TrackOptions, progress: FrameProgress | None = None) -> Track:
    """As :func:`track`, of a video that is open: several parts of it are tracked one by one.

    Exposure and readout that are not given are those of the part tracked before, ``beside``.
    """
    if options.beside is not None and film.shutters is None:
        film = film.exposed(options.beside.shutters)
    return beside_what_turns_evenly(method_of(options.method), film, options, progress)
