"""A method that is not known is refused before the video is read through."""

from __future__ import annotations

from pathlib import Path

import pytest

import servosight as ss
from servosight.tracking.core import TrackOptions
from servosight.tracking.track import track


def test_an_unknown_method_goes_first(tmp_path: Path) -> None:
    video = tmp_path / "fin.mp4"
    with pytest.raises(ss.InputError, match=r"'refien' is not known .*expected one of"):
        track(video, TrackOptions(method="refien"))
    with pytest.raises(ss.InputError, match=r"'refien' is not known .*expected one of"):
        ss.track(video, method="refien")  # type: ignore[arg-type]
