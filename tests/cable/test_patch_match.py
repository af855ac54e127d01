"""Fused points become cells as the sweep gives them; without CUDA the person is told so."""

import cv2  # noqa: F401 - before pycolmap
import numpy as np
import pycolmap
import pytest

from pipeline.cable.patch_match import grid_points, match_patches
from pipeline.cable.surface_view import SweepGrid
from pipeline.core.axis import AxisCurve
from pipeline.core.errors import StageError
from tests.cable import scene

AXIS = AxisCurve(origin_y_m=0.0, coefficients=np.zeros((2, 1)))
GRID = SweepGrid(axis=AXIS, azimuth=np.radians(np.arange(-20.0, 21.0)), y_m=np.arange(0.0, 0.05, 0.001))


def cloud(noise_mm=0.05, seed=1, count=60_000):
    rng = np.random.default_rng(seed)
    azimuth, y_m = np.radians(rng.uniform(-20, 20, count)), rng.uniform(0, 0.049, count)
    radius = scene.RADIUS_M + rng.normal(0, noise_mm / 1000, count)
    points = radius[:, None] * scene.out_of_cable(azimuth)
    points[:, 1] = y_m
    return points


def test_each_cell_takes_the_median_of_its_points():
    found = grid_points(cloud(), GRID)
    error_mm = 1000 * (found.radius_m - scene.RADIUS_M)
    assert np.isfinite(error_mm).mean() > 0.99
    assert abs(np.nanmean(error_mm)) < 0.002
    assert 0.005 < np.nanstd(error_mm) < 0.02  # about thirty points a cell


def test_the_halves_share_no_point_and_scatter_more_than_the_whole():
    found = grid_points(cloud(), GRID)
    halves = np.stack([found.radius_ahead_m, found.radius_behind_m])
    assert np.nanstd(halves[0] - halves[1]) > 1.3 * np.nanstd(found.radius_m)
    assert abs(np.corrcoef(halves[:, np.isfinite(halves).all(axis=0)])[0, 1]) < 0.1


def test_empty_cells_stay_empty_and_single_points_score_low():
    lone = scene.RADIUS_M * scene.out_of_cable(np.radians([0.0]))
    found = grid_points(lone + np.array([0, 0.02, 0]), GRID)
    assert np.isfinite(found.radius_m).sum() == 1
    assert np.nanmax(found.score) < 0.5


@pytest.mark.skipif(pycolmap.has_cuda, reason="this pycolmap can match patches")
def test_without_cuda_it_says_what_to_do(tmp_path, straight_view):
    with pytest.raises(StageError, match=r"needs a pycolmap built with CUDA.*leave dense.method at sweep"):
        match_patches(
            scene.sequence(()), scene.true_orientation(straight_view), GRID, tmp_path / "work", scene.silent
        )
    assert not (tmp_path / "work").exists()
