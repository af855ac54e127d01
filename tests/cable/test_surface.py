"""Outliers go, small holes close if wanted, nothing is made up at the border, and the TIN is the surface."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.cable.dense import RadiusMap
from pipeline.cable.surface import SurfaceOptions, build_surface, mesh_surface, smoothed
from pipeline.core.axis import AxisCurve

CELL_MM, RADIUS_MM = 0.5, 55.0


def cable_mm(azimuth, y_m):
    """A cable that tapers by 0.4 mm and is oval by 0.3 mm."""
    return RADIUS_MM + 2.0 * y_m + 0.15 * np.cos(2 * azimuth)


def dense_map(height_mm=cable_mm, noise_mm=0.0, seed=0):
    azimuth = np.arange(-70, 71) * CELL_MM / RADIUS_MM
    y_m = np.arange(201) * CELL_MM / 1000
    a, y = np.meshgrid(azimuth, y_m)
    noise = np.random.default_rng(seed).normal(0, noise_mm, a.shape)
    return RadiusMap(
        axis=AxisCurve(origin_y_m=0.05, coefficients=np.array([[0.001, 0.002], [-0.002, 0.001]])),
        azimuth=azimuth,
        y_m=y_m,
        radius_m=((height_mm(a, y) + noise) / 1000).astype(np.float32),
        score=np.full(a.shape, 0.9, dtype=np.float32),
        noise_mm=noise_mm,
        window_mm=3.0,
        ground_sample_mm=CELL_MM,
        coverage=1.0,
    )


def with_hole(dense, rows, columns):
    radius = dense.radius_m.copy()
    radius[rows, columns] = np.nan
    return replace(dense, radius_m=radius)


def truth_mm(surface):
    return cable_mm(*np.meshgrid(surface.azimuth, surface.y_m))


def test_a_clean_surface_stays_as_it_is():
    dense = dense_map(noise_mm=0.05)
    surface = build_surface(dense, SurfaceOptions())
    np.testing.assert_array_equal(surface.radius_m, dense.radius_m)
    assert surface.measured.all()


@pytest.mark.parametrize("off_mm", [0.9, -0.9, 5.0])
def test_a_cell_far_from_its_surroundings_is_dropped(off_mm):
    dense = dense_map(noise_mm=0.05)
    spikes = np.random.default_rng(4).random(dense.radius_m.shape) < 0.02
    spoiled = replace(dense, radius_m=dense.radius_m + np.float32(off_mm / 1000) * spikes)
    surface = build_surface(spoiled, SurfaceOptions())
    assert not surface.measured[spikes].any()
    assert surface.measured[~spikes].mean() > 0.999
    assert np.isfinite(surface.radius_m[1:-1, 1:-1]).mean() > 0.999  # the holes are closed again
    assert np.nanmax(np.abs(1000 * surface.radius_m - truth_mm(surface))) < 0.3


def test_a_dropped_cell_stays_a_hole_where_holes_are_kept():
    dense = dense_map()
    spoiled = dense.radius_m.copy()
    spoiled[100, 70] += 0.002
    surface = build_surface(replace(dense, radius_m=spoiled), SurfaceOptions(fill_mm=0))
    assert np.isnan(surface.radius_m[100, 70])
    assert np.isnan(surface.radius_m).sum() == 1


def test_a_step_and_a_weld_are_surface_and_no_outlier():
    def stepped(azimuth, y_m):
        return cable_mm(azimuth, y_m) + 1.0 * (y_m > 0.05)

    surface = build_surface(dense_map(stepped, noise_mm=0.03), SurfaceOptions())
    assert surface.measured.mean() > 0.995


@pytest.mark.parametrize("width_mm", [1.0, 3.0, 5.0])
def test_a_narrow_hole_is_closed_from_its_rims_and_marked_as_not_measured(width_mm):
    half = round(width_mm / CELL_MM / 2)
    hole = (slice(100 - half, 100 + half + 1), slice(70 - half, 70 + half + 1))
    surface = build_surface(with_hole(dense_map(), *hole), SurfaceOptions())
    assert np.isfinite(surface.radius_m).all()
    assert np.abs(1000 * surface.radius_m - truth_mm(surface))[hole].max() < 0.03
    expected = np.ones_like(surface.measured)
    expected[hole] = False
    np.testing.assert_array_equal(surface.measured, expected)


def test_a_wide_hole_stays():
    hole = (slice(80, 120), slice(50, 90))
    surface = build_surface(with_hole(dense_map(), *hole), SurfaceOptions())
    assert np.isnan(surface.radius_m[hole]).mean() > 0.95
    outside = np.ones_like(surface.measured)
    outside[hole] = False
    assert np.isfinite(surface.radius_m[outside]).all()


def test_every_hole_is_kept_by_choice():
    hole = (slice(98, 103), slice(68, 73))
    surface = build_surface(with_hole(dense_map(), *hole), SurfaceOptions(fill_mm=0))
    assert np.isnan(surface.radius_m[hole]).all()
    assert np.isnan(surface.radius_m).sum() == 25


BORDERS = {
    "missing rows": (slice(0, 5), slice(None)),
    "missing columns": (slice(None), slice(-4, None)),
    "a missing corner": (slice(0, 6), slice(0, 6)),
    "a wide bay": (slice(0, 30), slice(40, 70)),
    "a narrow notch": (slice(-30, None), slice(68, 73)),
}


@pytest.mark.parametrize("where", BORDERS)
def test_nothing_is_made_up_at_the_border(where):
    """What lies open to the border is not seen from all sides: no hole, but the end of what is known."""
    surface = build_surface(with_hole(dense_map(), *BORDERS[where]), SurfaceOptions())
    assert np.isnan(surface.radius_m[BORDERS[where]]).all()


def test_smoothing_takes_out_noise_and_keeps_shape_and_holes():
    hole = (slice(80, 120), slice(50, 90))
    surface = build_surface(with_hole(dense_map(noise_mm=0.1), *hole), SurfaceOptions(fill_mm=0))
    smooth = smoothed(surface, 3.0)
    np.testing.assert_array_equal(np.isnan(smooth.radius_m), np.isnan(surface.radius_m))
    inside = np.zeros_like(surface.measured)
    inside[10:70, 10:-10] = True
    before, after = (1000 * s.radius_m - truth_mm(surface) for s in (surface, smooth))
    assert 0.09 < before[inside].std() < 0.11
    # a Gaussian of sigma 1.5 mm = 3 cells averages about 4 pi 9 = 113 cells
    assert after[inside].std() == pytest.approx(0.1 / np.sqrt(113), rel=0.3)


def test_smoothing_does_not_pull_the_rims_of_holes_and_borders_down():
    """A cable that rises by 3 mm above its median here: the rim must not sink towards the middle."""
    dense = with_hole(
        dense_map(lambda a, y: RADIUS_MM + 3 * (y > 0.07) + 0 * a), slice(170, 185), slice(50, 90)
    )
    surface = build_surface(dense, SurfaceOptions(fill_mm=0))
    raised = np.isfinite(surface.radius_m) & (surface.y_m[:, None] > 0.078)
    np.testing.assert_allclose(1000 * smoothed(surface, 3.0).radius_m[raised], RADIUS_MM + 3, atol=0.005)


def test_surface_points_lie_about_the_block_s_own_axis():
    surface = build_surface(dense_map(), SurfaceOptions())
    points = surface.points(slice(0, 201, 50), slice(0, 141, 70))
    assert points.shape == (5, 3, 3)
    y = 0.075
    axis = [0.001 + 0.002 * (y - 0.05), -0.002 + 0.001 * (y - 0.05)]
    radius = cable_mm(0.0, y) / 1000
    np.testing.assert_allclose(points[3, 1], [axis[0] + radius, y, axis[1]], atol=1e-8)
    along, around = surface.cell_m
    assert along == pytest.approx(CELL_MM / 1000)
    assert around == pytest.approx(CELL_MM / 1000, rel=0.005)


def test_the_tin_has_the_area_of_the_cells_that_stand_and_the_wanted_edge():
    surface = build_surface(dense_map(), SurfaceOptions())
    stands = np.ones_like(surface.measured)
    stands[:101] = False
    mesh = mesh_surface(surface, stands, SurfaceOptions(mesh_mm=2.0))
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
    rows, arc = 0.1 - 0.052, 140 * CELL_MM / 1000  # rows 104 to 200 are every fourth one that stands
    assert area == pytest.approx(rows * arc, rel=0.01)
    edges = np.linalg.norm(np.concatenate([b - a, c - b, a - c]), axis=1)
    assert np.median(edges) == pytest.approx(0.002, rel=0.1)
    outward = np.sum(mesh.normals * (mesh.vertices - surface.axis.at(mesh.vertices[:, 1])), axis=1)
    assert outward.min() > 0
