"""The sweep finds the radius of a painted cable, bump included, and says nothing where there is nothing."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from pipeline.cable.surface_view import SurfaceView, SweepGrid
from pipeline.cable.sweep import FrameReader, StripFrames, SweepPass, sweep_strip
from pipeline.core.axis import AxisCurve
from tests.cable import scene

REFERENCE, AHEAD, BEHIND = 4, (6, 8), (2, 0)
WINDOW = 9
GRID = SweepGrid(
    axis=AxisCurve(origin_y_m=0.0, coefficients=np.zeros((2, 2))),
    azimuth=np.deg2rad(np.arange(-48, 48.1, 0.6)),
    y_m=REFERENCE * scene.STEP_M + 0.0006 * np.arange(-24, 25),
)


def sweep(view, start_mm=55.0, reach_mm=1.2, pictures=None, ahead=AHEAD, behind=BEHIND, along_sight=False):
    pictures = pictures or [view.picture(k)[..., 2] for k in range(scene.FRAMES)]
    start = np.full((len(GRID.y_m), len(GRID.azimuth)), start_mm / 1000, dtype=np.float32)
    offsets_m = np.arange(-reach_mm, reach_mm + 1e-9, 0.3) / 1000
    seen = frames(view, FrameReader(lambda k: pictures[k], 0.0), ahead, behind)
    return sweep_strip(
        seen, SweepPass(grid=GRID, start_m=start, offsets_m=offsets_m, window=WINDOW, along_sight=along_sight)
    )


def frames(view, read, ahead, behind):
    return StripFrames(
        read=read, lens=view.lens, poses=view.poses, reference=REFERENCE, ahead=ahead, behind=behind
    )


@pytest.fixture(scope="module")
def plain(barrel_view):
    return sweep(barrel_view)


def inner(values):
    """Away from the strip's borders, where windows reach into other candidates or their own reflection."""
    return values[WINDOW // 2 : -(WINDOW // 2), WINDOW // 2 : -(WINDOW // 2)]


def test_the_radius_of_a_cylinder_is_found_to_hundredths_of_a_millimetre(plain):
    error_mm = 1000 * (inner(plain.radius_m) - scene.RADIUS_M)
    assert np.isfinite(error_mm).mean() > 0.97
    assert abs(np.nanmedian(error_mm)) < 0.02
    assert 0.01 < 1.4826 * np.nanmedian(np.abs(error_mm)) < 0.08


def test_frames_agree_at_the_peak(plain):
    assert np.nanmedian(plain.score) > 0.9
    assert np.nanmax(plain.score) <= 1.001


@pytest.mark.parametrize("start_mm", [54.5, 55.45])
def test_the_answer_does_not_hang_on_where_the_search_begins(barrel_view, plain, start_mm):
    moved = sweep(barrel_view, start_mm=start_mm)
    difference_mm = 1000 * (inner(moved.radius_m) - inner(plain.radius_m))
    assert abs(np.nanmedian(difference_mm)) < 0.01
    assert np.nanmedian(np.abs(difference_mm)) < 0.03


@pytest.mark.parametrize("start_mm", [54.0, 55.2, 56.2])
def test_a_line_of_sight_tells_the_radius_where_it_ends(barrel_view, plain, start_mm):
    """It leaves the cell's own direction: 1.2 mm along it are 0.02 mm of radius more, 45 degrees aside."""
    slanted = sweep(barrel_view, start_mm=start_mm, reach_mm=2.1, along_sight=True)
    for found, expected in zip(
        np.array_split(inner(slanted.radius_m), 5, axis=1),
        np.array_split(inner(plain.radius_m), 5, axis=1),
        strict=True,
    ):
        assert abs(1000 * np.nanmedian(found - expected)) < 0.012
    assert np.nanmedian(slanted.score) > 0.9


def test_what_a_window_holds_does_not_hang_on_the_radius_that_is_asked_for(barrel_view):
    """Few specks in broad windows, noise, short baselines: there every slope of the agreement shows most.

    Cells in their place on the surface hold a larger part of the specks the smaller the radius.
    """
    grid = replace(GRID, y_m=REFERENCE * scene.STEP_M + 0.0006 * np.arange(-40, 41))
    start = np.full((len(grid.y_m), len(grid.azimuth)), scene.RADIUS_M, dtype=np.float32)
    offsets_m = np.arange(-3.6, 3.61, 0.6) / 1000
    errors_mm = {False: [], True: []}
    for draw in range(24):
        rng = np.random.default_rng(draw)
        if draw % 6 == 0:
            view = replace(barrel_view, texture=scene.Specks(draw, first_m=0.0, last_m=0.16))
            clean = {k: view.picture(k)[..., 2] for k in (3, 4, 5)}
        noisy = {k: picture + rng.normal(0, 4.0, picture.shape) for k, picture in clean.items()}
        reader = FrameReader(noisy.__getitem__, 0.5, 1.5)
        for along_sight, found_mm in errors_mm.items():
            found = sweep_strip(
                frames(view, reader, (5,), (3,)),
                SweepPass(grid=grid, start_m=start, offsets_m=offsets_m, window=31, along_sight=along_sight),
            )
            found_mm.append(1000 * (found.radius_m[15:-15, 15:-15] - scene.RADIUS_M))
    fixed_mm, kept_mm = (np.nanmedian(errors_mm[along_sight]) for along_sight in (False, True))
    assert fixed_mm < -0.1
    assert abs(kept_mm) < 0.04


def test_the_halves_share_no_neighbour_and_tell_the_same(plain):
    """Their difference never flatters: errors of the common reference cancel in the whole, not in it."""
    differs_mm = 1000 * inner(plain.radius_ahead_m - plain.radius_behind_m)
    assert abs(np.nanmedian(differs_mm)) < 0.03
    error_mm = 1000 * (inner(plain.radius_m) - scene.RADIUS_M)
    half_of_difference = np.nanmedian(np.abs(differs_mm)) / 2
    assert 0.8 < half_of_difference / np.nanmedian(np.abs(error_mm)) < 5


def bump(azimuth, y_m):
    """One millimetre high, Gaussian, sigma 8 mm."""
    around = scene.RADIUS_M * np.angle(np.exp(1j * (azimuth - 0.2)))
    return 0.001 * np.exp(-(around**2 + (y_m - REFERENCE * scene.STEP_M) ** 2) / (2 * 0.008**2))


def test_a_bump_has_its_height_and_its_place():
    view = scene.Scene(poses=scene.poses(), lens=scene.lens(scene.BARREL), height_m=bump)
    found_mm = 1000 * (sweep(view, reach_mm=1.8).radius_m - scene.RADIUS_M)
    azimuth, y_m = np.meshgrid(GRID.azimuth, GRID.y_m)
    error_mm = inner(found_mm - 1000 * bump(azimuth, y_m))
    assert abs(np.nanmedian(error_mm)) < 0.02
    assert np.nanpercentile(np.abs(error_mm), 90) < 0.25
    near = bump(azimuth, y_m) > 0.9e-3
    assert 0.8 < np.nanmedian(found_mm[near]) < 1.05  # the window of 5.5 mm rounds the top


def test_the_end_of_the_search_range_is_no_answer(barrel_view):
    beside = sweep(barrel_view, start_mm=57.5, reach_mm=0.9)  # the surface lies below the range
    assert np.isnan(inner(beside.radius_m)).mean() > 0.97
    np.testing.assert_array_equal(np.isnan(beside.score), np.isnan(beside.radius_m))


def test_a_surface_just_outside_the_search_range_is_not_guessed_at(barrel_view):
    """Half a step beyond the last candidate a parabola would still point there: by chance or not."""
    below = sweep(barrel_view, start_mm=56.35, reach_mm=1.2)
    assert np.isnan(inner(below.radius_m)).mean() > 0.9


def test_what_has_no_texture_agrees_with_nothing(barrel_view):
    even = [np.full((scene.HEIGHT_PX, scene.WIDTH_PX), 120, dtype=np.uint8)] * scene.FRAMES
    nothing = sweep(barrel_view, pictures=even)
    assert not (nothing.score > 0.1).any()


def test_noise_alone_agrees_with_nothing(barrel_view):
    rng = np.random.default_rng(0)
    noise = [rng.integers(0, 255, (scene.HEIGHT_PX, scene.WIDTH_PX), dtype=np.uint8) for _ in range(10)]
    assert np.nanpercentile(sweep(barrel_view, pictures=noise).score, 95) < 0.5


def test_an_end_frame_has_one_half_only(barrel_view):
    found = sweep(barrel_view, behind=())
    assert np.isnan(found.radius_behind_m).all()
    np.testing.assert_array_equal(found.radius_m, found.radius_ahead_m)
    assert abs(1000 * np.nanmedian(inner(found.radius_m)) - 55) < 0.03


def test_cells_are_looked_up_where_the_lens_really_puts_them(barrel_view):
    """Against the independent projection; OpenCV's origin is half a pixel inside ours."""
    radius = np.full((len(GRID.y_m), len(GRID.azimuth)), 0.0553, dtype=np.float32)
    column, row = SurfaceView(barrel_view.lens, barrel_view.poses, REFERENCE, GRID).pixels(radius)
    azimuth, y_m = np.meshgrid(GRID.azimuth, GRID.y_m)
    points = 0.0553 * scene.out_of_cable(azimuth) + y_m[..., None] * [0, 1, 0]
    truth = barrel_view.project(REFERENCE, points.reshape(-1, 3))
    np.testing.assert_allclose(np.stack([column.ravel(), row.ravel()], axis=1), truth - 0.5, atol=1e-3)


def test_cells_whose_window_leaves_the_picture_are_not_used(barrel_view):
    far = SweepGrid(axis=GRID.axis, azimuth=GRID.azimuth, y_m=np.linspace(-0.05, 0.2, 251))
    view = SurfaceView(barrel_view.lens, barrel_view.poses, REFERENCE, far)
    radius = np.full((251, len(GRID.azimuth)), scene.RADIUS_M, dtype=np.float32)
    column, _ = view.pixels(radius)
    visible = view.visible(view.pixels(radius), WINDOW) > 0
    inside = (column > 1) & (column < scene.WIDTH_PX - 3)
    kernel = np.ones((WINDOW, WINDOW), dtype=np.uint8)
    np.testing.assert_array_equal(visible, cv2.erode(inside.astype(np.uint8), kernel, borderValue=1) > 0)
    assert 0.5 < visible.mean() < 0.9


def test_frames_are_read_once_and_forgotten_when_there_are_too_many():
    asked = []

    def read(frame):
        asked.append(frame)
        return np.full((8, 8), frame, dtype=np.uint8)

    reader = FrameReader(read, blur_px=1.0, keep=2)
    for frame in (0, 1, 0, 2, 0, 1):
        assert reader[frame].mean() == frame
    assert asked == [0, 1, 2, 1]


def test_slow_shading_is_taken_off_and_fine_marks_stay():
    column = np.arange(64.0)
    marks = 20 * np.cos(np.pi * column)  # every other column
    bare, shaded = (
        FrameReader(lambda _, p=picture: np.tile(p, (32, 1)), blur_px=0.0, detail_px=1.5)[0][16, 8:-8]
        for picture in (100 + marks, 60 + 1.5 * column + marks)
    )
    np.testing.assert_allclose(shaded, bare, atol=0.01)
    np.testing.assert_allclose(bare, marks[8:-8], atol=0.3)


def test_a_frame_further_away_counts_for_more_when_it_is_asked_for(barrel_view):
    """Two frames on one side, the near one from a wrong place: the far one wins with the power."""
    pictures = [barrel_view.picture(k)[..., 2] for k in range(scene.FRAMES)]
    pictures[6] = pictures[5]  # seen from 20 mm away, believed 40 mm away
    start = np.full((len(GRID.y_m), len(GRID.azimuth)), 0.055, dtype=np.float32)
    offsets_m = np.arange(-1.2, 1.21, 0.3) / 1000
    seen = frames(barrel_view, FrameReader(lambda k: pictures[k], 0.0), (6, 8), ())
    wanted = SweepPass(grid=GRID, start_m=start, offsets_m=offsets_m, window=WINDOW)
    scores = [
        np.nanmedian(inner(sweep_strip(seen, replace(wanted, baseline_power=power)).score))
        for power in (0.0, 2.0)
    ]
    assert scores[0] < 0.65 < 0.7 < scores[1]
