"""The exposure that the blur of a part shows, and what is said where it shows none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import cv2
import numpy as np
import pytest

from servosight.models.core import Array, Image, Single
from servosight.tracking.calibration.shutter import least_residual, steady_shear
from servosight.tracking.composite import PartMeter, PoseFit
from servosight.tracking.composite._exposure import BlurModel, FastPictures, weighted_mean
from servosight.tracking.composite.model._model import CompositeModel
from servosight.tracking.composite.model._raster import PartRaster
from servosight.tracking.core import Shutter, Track, TrackOptions, turned
from servosight.tracking.methods._composite import composite
from servosight.tracking.methods._composite_track import unexplained_rad
from servosight.tracking.uncertainty import by_delay
from servosight.tracking.verification import PolarView
from servosight.tracking.video import open_film

Write = Callable[[Path, list[Image], Array], Path]

FRAMES, RATE_HZ = 72, 30.0
EXPOSURE_S = 0.4 / RATE_HZ
FAST_HZ, SLOW_HZ = 1.06, 0.13
START_S = np.arange(FRAMES) / RATE_HZ
SIZE, PIVOT = (200, 160), (96.0, 84.0)
BAR = np.array([[-6.0, -4.0], [66.0, -4.0], [66.0, 4.0], [-6.0, 4.0]])


def angle_deg(time_s: Array, rate_hz: float) -> Array:
    """A swing of 45 deg; at 1.06 Hz of 10 deg from frame to frame as it passes the middle."""
    return np.asarray(45.0 * np.sin(2.0 * np.pi * rate_hz * time_s + 0.3))


def filmed(rate_hz: float, readout_s: float = 0.0) -> list[Image]:
    """A bar over texture; each row is the mean of twelve instants of its exposure."""
    step_s = EXPOSURE_S / 12.0
    late_s = step_s * (np.arange(12 + int(np.ceil(readout_s / step_s))) + 0.5)
    row_s = readout_s * np.arange(SIZE[1])[:, None] / (SIZE[1] - 1)
    exposed = (late_s > row_s) & (late_s < row_s + EXPOSURE_S)
    shares = exposed / exposed.sum(1, keepdims=True)
    rng = np.random.default_rng(7)
    texture = cv2.GaussianBlur(rng.standard_normal(SIZE[::-1]), (0, 0), 2.0)
    still = (110.0 + 60.0 * texture).astype(np.float32)
    pictures = []
    for start_s in START_S:
        image = np.zeros(still.shape)
        for angle, share in zip(angle_deg(start_s + late_s, rate_hz), shares.T, strict=True):
            corners = turned(np.add(BAR, PIVOT), PIVOT, float(np.deg2rad(angle)))
            seen = still.copy()
            outline = np.round(256.0 * corners).astype(np.int32)
            cv2.fillPoly(seen, [outline], 235.0, cv2.LINE_AA, shift=8)
            image += share[:, None] * seen
        image += rng.normal(0.0, 1.0, image.shape)
        pictures.append(np.clip(np.round(image), 0, 255).astype(np.uint8))
    return pictures


def tracked(
    folder: Path, write: Write, rate_hz: float, options: TrackOptions, readout_s: float = 0.0
) -> Track:
    video = write(folder / "swing.mkv", filmed(rate_hz, readout_s), START_S)
    return composite(open_film(video, options), options)


def error_deg(track: Track, rate_hz: float) -> Array:
    """Of the angle at the track's own times."""
    away = track.angle_deg - angle_deg(track.time_s, rate_hz)
    return np.asarray(away - np.median(away))


@pytest.fixture(scope="module")
def fast(tmp_path_factory: pytest.TempPathFactory, write: Write) -> Track:
    """The fast swing with nothing given."""
    return tracked(tmp_path_factory.mktemp("fast"), write, FAST_HZ, TrackOptions())


def test_blur_tells_the_exposure_and_times_are_its_middle(fast: Track) -> None:
    """Truth: exposure 13.3 ms of 33.3 ms. Found within 2 sigma, which is 3 ms at most; times are
    its middle. By its start the angle would be 1.4 deg rms wrong: bounds 0.3 deg and 1.3 sigma."""
    track = fast
    assert track.shutters is not None
    assert track.shutters.exposure_doubt_s < 0.003
    assert abs(track.shutters.usual_s - EXPOSURE_S) < 2.0 * track.shutters.exposure_doubt_s
    np.testing.assert_allclose(track.time_s - START_S, track.shutters.middle_s, atol=2e-5)
    assert abs(track.shutters.middle_s - 0.5 * EXPOSURE_S) < 2.0 * track.shutters.middle_doubt_s
    error = error_deg(track, FAST_HZ)
    assert np.sqrt(np.mean(error**2)) < 0.3
    assert np.sqrt(np.mean((error / track.sigma_deg) ** 2)) < 1.3
    assert any("found from motion blur" in note for note in track.notes)


def beside_tilt(change: Array, track: Track) -> Array:
    """What of changes (frames, errors) is none by a camera off the axis, which depends on the angle
    alone, by its first two harmonics."""
    rad = np.deg2rad(track.angle_deg)
    rows = [np.ones(FRAMES), *(wave(n * rad) for n in (1, 2) for wave in (np.cos, np.sin))]
    basis = np.linalg.qr(np.column_stack(rows))[0]
    return np.asarray(change - basis @ (basis.T @ change))


def test_the_error_of_all_times_is_shared(fast: Track) -> None:
    """In proportion to the speed, with its sign; sigma includes it and the tilt's, which are kept
    as independent errors without those below 1 % of the largest."""
    assert fast.shutters is not None
    assert fast.shared_deg is not None
    speed = np.gradient(fast.angle_deg, fast.time_s)[:, None]
    expected = beside_tilt(speed * fast.shutters.middle_doubt_s, fast)
    found = beside_tilt(fast.shared_deg, fast)
    covariance = expected @ expected.T
    np.testing.assert_allclose(found @ found.T, covariance, atol=0.02 * covariance.max())
    assert np.mean(fast.sigma_deg**2) > np.mean(np.sum(fast.shared_deg**2, axis=1))


def test_a_given_exposure_leaves_no_such_error(tmp_path: Path, write: Write) -> None:
    given = tracked(tmp_path, write, FAST_HZ, TrackOptions(exposure_s=EXPOSURE_S))
    assert given.shared_deg is not None
    np.testing.assert_allclose(beside_tilt(given.shared_deg, given), 0.0, atol=1e-9)
    np.testing.assert_allclose(given.time_s - START_S, 0.5 * EXPOSURE_S, atol=2e-5)
    assert np.sqrt(np.mean(error_deg(given, FAST_HZ) ** 2)) < 0.15


def test_angles_are_those_of_the_middle_row(tmp_path: Path, write: Write) -> None:
    """Truth: 16.7 ms from the first row to the last one, in which the bar turns by 5 deg. Taken for
    those of the middle row, the angles at its own rows are 0.41 deg rms off; bound 0.15 deg."""
    readout_s = 0.5 / RATE_HZ
    known = TrackOptions(exposure_s=EXPOSURE_S, readout_s=readout_s)
    track = tracked(tmp_path, write, FAST_HZ, known, readout_s)
    late_s = 0.5 * (EXPOSURE_S + readout_s)
    np.testing.assert_allclose(track.time_s - START_S, late_s, atol=2e-5)
    assert np.sqrt(np.mean(error_deg(track, FAST_HZ) ** 2)) < 0.15


def test_a_slow_part_does_not_tell_the_exposure(tmp_path: Path, write: Write) -> None:
    """1.2 deg a frame at most, a blur of 0.5 px. Truth 13.3 ms; about what is likely of any camera,
    0.36 of the time from frame to frame, 11.9 ms, with nearly the sigma of that, 9.4 ms."""
    track = tracked(tmp_path, write, SLOW_HZ, TrackOptions(pivot=PIVOT))
    assert track.shutters is not None
    assert track.shutters.usual_s == pytest.approx(0.36 / RATE_HZ, abs=0.1 / RATE_HZ)
    assert track.shutters.exposure_doubt_s == pytest.approx(0.28 / RATE_HZ, rel=0.1)
    assert np.sqrt(np.mean((error_deg(track, SLOW_HZ) / track.sigma_deg) ** 2)) < 1.3


def test_a_badly_explained_frame_has_a_larger_sigma() -> None:
    """Of a part in full view 65 % at least is explained; all that is missing may be a turn."""
    fit = PoseFit(0.0, np.zeros(2), np.zeros((3, 3)), 1.0, 0.9, 1.0, 0.0, 0.0, 0.1, 0.0, 0.0)
    assert unexplained_rad(fit) == 0.0
    assert unexplained_rad(replace(fit, explained=0.4)) == pytest.approx(0.1 * 0.5)


def test_blur_on_the_raster_is_the_mean_over_the_turn() -> None:
    """Truth: a block 20 columns wide, seen while it turns by 10.5 columns, and a row all round."""
    view = PolarView((0.0, 0.0), 2, 120)
    cover = np.zeros((2, 120), np.float32)
    cover[0, :20], cover[1] = 1.0, 1.0
    raster = PartRaster(view, cover, 100.0 * cover, cover > 0.5, np.zeros((4, 4), np.float32))
    blurred = raster.blurred(10.5 * view.step_rad)
    shifts = (np.arange(10_000) + 0.5) / 10_000 * 10.5 - 5.25
    at = np.arange(120)[:, None] - shifts
    true = ((at + 0.5) % 120 < 20).mean(1)
    np.testing.assert_allclose(blurred.cover[0], true, atol=1e-3)
    np.testing.assert_allclose(blurred.level[0], 100.0 * true, atol=0.1)
    np.testing.assert_allclose(blurred.cover[1], 1.0, atol=1e-5)
    assert raster.reached(10.5 * view.step_rad)[0].sum() == 20 + 2 * 6
    assert raster.blurred(0.0).cover is cover


def test_no_angle_no_delay_error() -> None:
    found = np.array([True, True, False, True])
    change = by_delay(np.array([0.0, 1.0, 1.0, 3.0]), np.arange(4) / 10.0, found, 0.01)
    np.testing.assert_allclose(change.ravel(), [0.1, 0.1, 0.0, 0.1])
    assert not by_delay(np.zeros(4), np.arange(4) / 10.0, ~found, 0.01).any()


@dataclass(frozen=True)
class Sector:
    """A sector over texture, its edges as wide as a turn by some pixels at its rim makes them."""

    soft_px: float

    @cached_property
    def raster(self) -> PartRaster:
        rng = np.random.default_rng(5)
        texture = cv2.GaussianBlur(rng.standard_normal((130, 130)), (0, 0), 2.0)
        view = PolarView((64.0, 64.0), 50, 320)
        shape = np.zeros((50, 320), np.float32)
        shape[4:44, 5:60] = 1.0
        behind = (90.0 + 60.0 * texture).astype(np.float32)
        bare = PartRaster(view, shape, 220.0 * shape, shape > 0.5, behind)
        return replace(bare.blurred(self.soft_px / 44.0), near=bare.near)

    def pictures(self, angles: Array, turns: Array, shears: Array | None = None) -> Single:
        """At angles (n,), each the mean over a turn (n,) [rad], with noise of a grey level.

        The last row shows the part turned by ``shears`` (n,) [rad] against the first.
        """
        shears = np.zeros(angles.size) if shears is None else shears
        rng = np.random.default_rng(6)
        view, behind = self.raster.view, self.raster.behind
        y, x = np.indices(behind.shape) - 64.0
        row, column = np.hypot(x, y) - 0.5, np.arctan2(-y, x) / view.step_rad
        seen = []
        for angle, turn, shear in zip(
            angles.tolist(), turns.tolist(), shears.tolist(), strict=True
        ):
            cover = self.raster.blurred(turn).cover
            turned_rad = angle + shear * (y / (behind.shape[0] - 1) + 64.0 / 129.0 - 0.5)
            place = np.mod(column - turned_rad / view.step_rad, view.columns)
            shown = cv2.remap(
                np.hstack([cover, cover[:, :1]]), place.astype(np.float32),
                row.astype(np.float32), cv2.INTER_LINEAR,
            )  # fmt: skip
            noise = rng.normal(0.0, 1.0, shown.shape)
            seen.append(behind + shown * (220.0 - behind) + noise)
        return np.array(seen, np.float32)


class UnevenSector(Sector):
    """With one edge blurred over 6 columns of the raster, and the other over 12."""

    @cached_property
    def raster(self) -> PartRaster:
        sharp = super().raster
        less, more = (sharp.blurred(columns * sharp.view.step_rad) for columns in (6.0, 12.0))
        first = np.arange(sharp.view.columns) < 32
        cover = np.where(first, less.cover, more.cover)
        return replace(sharp, cover=cover, level=220.0 * cover)


def learnt_at_rest(sector: Sector) -> BlurModel:
    """From slow pictures at several angles, given a shape with sharp edges."""
    raster, angles = sector.raster, np.linspace(-1.0, 1.0, 24)
    stack = sector.pictures(angles, np.zeros(24))
    shape = raster.near.astype(np.float32)
    model = CompositeModel.of(
        stack, angles, raster.view.pivot_px, shape, raster.view, raster.behind
    )
    meter = cast(PartMeter, SimpleNamespace(model=model, shape=shape, view=raster.view))
    speed = np.where(np.arange(24) % 2, 20.0, 0.0)
    return BlurModel.of(meter, stack, angles, speed, 0.02)


@pytest.mark.parametrize("soft_px", [0.0, 8.0, 14.0])
def test_edges_of_a_part_at_rest_are_no_blur(soft_px: float) -> None:
    """Whatever their width, less than 2 px at the rim are left."""
    blur = learnt_at_rest(Sector(soft_px))
    assert blur.own_speed == 0.0
    assert blur.own_rad * 44.0 <= 2.0


@pytest.mark.parametrize("soft_px", [8.0, 14.0])
def test_how_much_a_part_covers_is_learnt_from_what_is_behind_it(soft_px: float) -> None:
    """Truth: edges of ``soft_px``, wider than a cell of the raster. Noise of a grey level over a
    texture of 60 levels leaves 0.01 of the cover, twelve pictures interpolated on a raster 0.02:
    bound 0.04 between the ends, which are one cell wide."""
    sector = Sector(soft_px)
    blur = learnt_at_rest(sector)
    between = blur.raster.near & (np.arange(50) > 8)[:, None] & (np.arange(50) < 40)[:, None]
    away = (blur.raster.cover - sector.raster.cover)[between]
    assert np.sqrt(np.mean(away**2)) < 0.04


def test_what_is_wrong_beside_a_part_in_any_case_is_not_taken_for_blur() -> None:
    """Sixteen pictures blurred over 6 columns of the raster, with a bright patch near the hub that
    the model does not know. It counts little: the best of some blurs is 6 columns with weights."""
    sector = Sector(4.0)
    step = sector.raster.view.step_rad
    angles = np.linspace(-1.0, 1.0, 16)
    stack = sector.pictures(angles, np.full(16, 6.0 * step))
    for picture, angle in zip(stack, angles.tolist(), strict=True):
        x, y = 64.0 + 12.0 * np.cos(angle + 0.1), 64.0 - 12.0 * np.sin(angle + 0.1)
        cv2.circle(picture, (round(x), round(y)), 5, 250.0, -1)

    def at(speed: float, exposure_s: float) -> CompositeModel:
        blurred = sector.raster.blurred(speed * exposure_s)
        return CompositeModel.on(blurred, 12.0 * step, 3000)

    seen = FastPictures(at, stack, angles, np.ones(16))
    weight = seen.weights(12.0 * step)
    tried = np.arange(0.0, 13.0)
    tables = [seen.squares(Shutter(float(columns) * step)) for columns in tried]
    area = at(0.0, 0.0).radius_px
    left = [weighted_mean(table, weight).mean() for table in tables]
    assert tried[int(np.argmin(left))] == 6.0
    counts = weight / area**3
    assert counts[area < 18.0].min() < 0.05 * np.median(counts)


def test_cells_that_disagree_on_the_exposure_count_alike() -> None:
    """One edge is blurred over 6 columns of the raster and the other over 12.
    While the exposure that suits all cells best decided, one edge counted 27 times the other."""
    sector = Sector(4.0)
    step = sector.raster.view.step_rad
    angles = np.linspace(-1.0, 1.0, 16)
    stack = UnevenSector(4.0).pictures(angles, np.zeros(16))

    def at(speed: float, exposure_s: float) -> CompositeModel:
        blurred = sector.raster.blurred(speed * exposure_s)
        return CompositeModel.on(blurred, 12.0 * step, 3000)

    seen = FastPictures(at, stack, angles, np.ones(16))
    model = at(0.0, 0.0)
    counts = seen.weights(48.0 * step) / model.radius_px**3
    away = np.abs((model.phi_rad / step - 32.0 + 160.0) % 320.0 - 160.0)
    edge = (away > 20.0) & (model.radius_px > 20.0)
    leading = edge & (model.phi_rad / step < 32.0)
    ratio = counts[leading].mean() / counts[edge & ~leading].mean()
    assert 0.5 < ratio < 2.0


@pytest.mark.parametrize("fewer", [1.0, 0.4])
def test_a_shear_at_any_speed_is_no_readout(fewer: float) -> None:
    """Truth: 0.15 rad from the first to the last row, whatever the speed, and no readout; parts
    turn to one side as fast as to the other, or at 0.4 of that. Shears are tried in steps of 0.03
    rad: bound one of them, and as much of a readout."""
    sector, angles = Sector(4.0), np.linspace(-1.0, 1.0, 16)
    stack = sector.pictures(angles, np.zeros(16), np.full(16, 0.15))

    def at(speed: float, exposure_s: float) -> CompositeModel:
        return CompositeModel.on(sector.raster.blurred(speed * exposure_s), 0.0, 3000)

    weight, speed = np.ones(at(0.0, 0.0).radius_px.size), np.tile([1.0, -fewer], 8)
    seen = FastPictures(at, stack, angles, speed)

    def left(shutter: Shutter, steady_rad: float = 0.0) -> Array:
        sheared = replace(seen, steady_rad=steady_rad)
        return weighted_mean(sheared.squares(shutter), weight)

    steady_rad, alike = steady_shear(left, speed, 0.25)
    assert steady_rad == pytest.approx(0.15, abs=0.031)
    assert alike == pytest.approx((1.0 - fewer) / np.sqrt(2.0 * (1.0 + fewer**2)), abs=1e-9)
    rolls = np.linspace(-0.15, 0.15, 16)
    readout_s, _ = least_residual(rolls, [left(Shutter(0.0, s), steady_rad) for s in rolls])
    assert readout_s == pytest.approx(0.0, abs=0.03)


def test_speeds_of_one_sign_do_not_tell_a_steady_shear() -> None:
    """It is left to the readout, and alike to one."""
    assert steady_shear(lambda shutter: np.ones(16), np.linspace(1.0, 2.0, 16), 0.5) == (0.0, 1.0)


def test_a_piece_of_the_pictures_takes_its_share_of_the_readout() -> None:
    sector, angles = Sector(4.0), np.linspace(-0.5, 0.5, 8)
    stack = sector.pictures(angles, np.zeros(8))

    def at(speed: float, exposure_s: float) -> CompositeModel:
        return CompositeModel.on(sector.raster.blurred(speed * exposure_s), 0.0, 1000)

    whole, half = (FastPictures(at, stack, angles, np.ones(8), share) for share in (1.0, 0.5))
    found = half.squares(Shutter(0.0, 0.2))
    np.testing.assert_allclose(found, whole.squares(Shutter(0.0, 0.1)))
    assert not np.allclose(found, whole.squares(Shutter(0.0, 0.2)))
