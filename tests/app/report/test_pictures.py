"""A report's frame of the film, its geometry, and the lines of its figures."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from support.drawn_film import FIN, PIVOT, filmed
from support.reports import RATE_HZ, written

from servosight.app.report.figure import NARROW, POINTS, WIDE, legend_above, thinned
from servosight.diagnose import Diagnosis, predictions
from servosight.models.core import Recording, degrees
from servosight.scenarios.produce import OURS
from servosight.sources import TRACK_FILE, geometry_of


@pytest.mark.usefixtures("unpainted")
def test_the_frame_shows_where_the_model_is_off(
    tmp_path: Path, found: Diagnosis, recording: Recording
) -> None:
    film = filmed(recording, tmp_path, RATE_HZ)
    text, page = written(tmp_path / "report.html", found, [film])
    assert "picture" in page.ids
    error = predictions(found, [film], 0)[0].error_deg
    worst = int(np.argmax(np.abs(error)))
    assert f"frame {worst} of" in page.text
    assert f"off by {degrees(abs(error[worst]))}" in page.text
    # The fin's tip is 150 px from its pivot: the outlines lie that far apart, to the smoothing.
    polygons = re.findall(r'<polygon class="(measured|before)" points="([^"]*)"', text)
    shapes = {kind: np.array([p.split(",") for p in v.split()], float) for kind, v in polygons}
    apart = np.hypot(*(shapes["measured"] - shapes["before"]).T).max()
    assert apart == pytest.approx(150.0 * 2.0 * np.sin(np.deg2rad(abs(error[worst])) / 2), rel=0.03)
    assert text.count("data:image/jpeg") == 2  # the whole picture, and what stands before the film
    assert text.count("data:image/png") == 1


def test_geometry_is_kept_only_while_it_fits(tmp_path: Path, recording: Recording) -> None:
    assert geometry_of(recording) is None
    assert TRACK_FILE in OURS  # a recording filmed anew replaces it
    film = filmed(recording, tmp_path, RATE_HZ)
    kept = geometry_of(film)
    assert kept is not None
    assert kept.pivot_px == PIVOT
    np.testing.assert_allclose(kept.outline_px[0], FIN[0], atol=0.01)
    fewer = replace(film, time_s=film.time_s[:-1], angle_deg=film.angle_deg[:-1])
    assert geometry_of(fewer) is None
    for text in ("format = 1", "junk [", 'pivot_px = "x"\noutline_px = 3'):
        (tmp_path / "track.toml").write_text(text)
        assert geometry_of(film) is None
    assert film.video is not None
    with film.video.open("ab") as stream:
        stream.write(b"more")
    filmed(recording, tmp_path, RATE_HZ)
    assert geometry_of(film) is not None
    with film.video.open("ab") as stream:
        stream.write(b"more")
    assert geometry_of(film) is None


def test_long_lines_keep_their_peaks() -> None:
    x = np.arange(100_000.0)
    line = np.sin(x / 5000.0)
    line[61_234] = 9.0
    ((kept_x, kept),) = thinned(x, line)
    assert kept.size <= 2 * POINTS
    assert kept.max() == 9.0
    assert np.all(np.diff(kept_x) > 0)
    short = thinned(x[:10], line[:10])[0][1]
    np.testing.assert_array_equal(short, line[:10])


@pytest.mark.parametrize("width", [WIDE, NARROW])
def test_a_legend_with_a_long_name_stays_within_its_figure(width: float) -> None:
    names = ["command", "measured", "linear model"]
    names.append("with directional friction, load-dependent Stribeck friction and a gravity load")
    figure = Figure((width, 4.0), layout="constrained")
    axes = figure.subplots()
    handles = [axes.plot([0.0, 1.0])[0] for _ in names]
    legend_above(figure, handles, names)
    figure.draw_without_rendering()
    place = figure.legends[0].get_window_extent()
    assert place.x0 >= 0.0
    assert place.x1 <= figure.bbox.x1
