"""Where a finer sweep begins: relief kept, noise and outliers gone, holes closed."""

import numpy as np
import pytest

from pipeline.cable.start_surface import edge_keeping_start, smooth_start
from pipeline.cable.surface_view import SweepGrid
from pipeline.cable.sweep import SweepResult
from pipeline.core.axis import AxisCurve

RADIUS_M = 0.055


def grid(cell_mm, rows, columns):
    return SweepGrid(
        axis=AxisCurve(origin_y_m=0.0, coefficients=np.zeros((2, 2))),
        azimuth=np.arange(columns) * cell_mm / 1000 / RADIUS_M,
        y_m=np.arange(rows) * cell_mm / 1000,
    )


SWEPT, WANTED = grid(0.7, 80, 60), grid(0.35, 159, 119)


def found(radius_m, differs_m=0.0, score=0.9):
    radius = np.asarray(radius_m, dtype=np.float32)
    return SweepResult(
        radius_m=radius,
        score=np.where(np.isfinite(radius), score, np.nan).astype(np.float32),
        radius_ahead_m=radius + np.float32(0.5) * np.asarray(differs_m, dtype=np.float32),
        radius_behind_m=radius - np.float32(0.5) * np.asarray(differs_m, dtype=np.float32),
    )


def rib_m(cells):
    """8 mm wide, 2 mm high, along the cable through the middle."""
    across = 1000 * RADIUS_M * (cells.azimuth - cells.azimuth.mean())
    profile = 0.002 * np.cos(np.pi * np.clip(across / 8, -0.5, 0.5)) ** 2
    return np.tile(RADIUS_M + profile, (len(cells.y_m), 1))


def test_a_rib_is_kept():
    start = edge_keeping_start(found(rib_m(SWEPT)), SWEPT, WANTED, RADIUS_M)
    error_mm = 1000 * np.abs(start - rib_m(WANTED))
    assert error_mm.max() < 0.15
    assert (
        np.abs(1000 * (smooth_start(found(rib_m(SWEPT)), SWEPT, WANTED, RADIUS_M) - rib_m(WANTED))).max()
        > 0.2
    )


@pytest.mark.parametrize("smooth", [edge_keeping_start, smooth_start])
def test_noise_is_smoothed(smooth):
    noise = np.random.default_rng(0).normal(0, 0.05e-3, (80, 60))
    start = smooth(found(RADIUS_M + noise), SWEPT, WANTED, RADIUS_M)
    assert 1e-6 < start.std() < 0.02e-3
    assert abs(start.mean() - RADIUS_M) < 0.005e-3


def test_outliers_and_cells_whose_halves_differ_do_not_count():
    radius, differs = rib_m(SWEPT), np.zeros((80, 60))
    radius[20:80:20, 10::20] += 0.0009
    radius[10, 40:44] += 0.003
    differs[10, 40:44] = 0.002
    start = edge_keeping_start(found(radius, differs), SWEPT, WANTED, RADIUS_M)
    clean = edge_keeping_start(found(rib_m(SWEPT)), SWEPT, WANTED, RADIUS_M)
    assert 1000 * np.abs(start - clean).max() < 0.12


def test_holes_take_what_surrounds_them():
    radius = np.full((80, 60), RADIUS_M) + 0.001 * (np.arange(60) > 30)
    radius[30:40, 5:12] = np.nan
    radius[30:40, 48:55] = np.nan
    start = edge_keeping_start(found(radius), SWEPT, WANTED, RADIUS_M)
    assert np.isfinite(start).all()
    assert 1000 * abs(start[70, 17] - RADIUS_M) < 0.1
    assert 1000 * abs(start[70, 103] - RADIUS_M - 0.001) < 0.1


@pytest.mark.parametrize("smooth", [edge_keeping_start, smooth_start])
def test_where_nothing_is_known_the_given_radius_stands(smooth):
    start = smooth(found(np.full((80, 60), np.nan)), SWEPT, WANTED, 0.06)
    assert start.shape == (159, 119)
    np.testing.assert_allclose(start, 0.06, rtol=1e-6)
