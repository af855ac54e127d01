"""The limb is cut where the line of sight grazes, ragged and doubtful parts go, the rest stays."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.cable.crop import CropOptions, crop_block, incidence_deg
from pipeline.cable.surface import BlockSurface
from pipeline.core.axis import AxisCurve
from pipeline.core.errors import StageError

RADIUS_M, STANDOFF_M, CELL_M = 0.055, 0.3, 0.0005


def block_surface(azimuth_deg=0.0):
    azimuth = np.deg2rad(azimuth_deg) + np.deg2rad(np.linspace(-75, 75, 301))
    shape = (120, 301)
    return BlockSurface(
        axis=AxisCurve(origin_y_m=0.0, coefficients=np.zeros((2, 2))),
        azimuth=azimuth,
        y_m=CELL_M * np.arange(120),
        radius_m=np.full(shape, RADIUS_M, dtype=np.float32),
        measured=np.ones(shape, dtype=bool),
        score=np.full(shape, 0.9, dtype=np.float32),
    )


def crop(surface, azimuth_deg=0.0, **options):
    return crop_block("Block1", surface, azimuth_deg, STANDOFF_M, CropOptions(**options))


def spoiled(surface, rows, columns, **changes):
    """The surface with other values in one patch."""
    fields = {name: getattr(surface, name).copy() for name in changes}
    for name, value in changes.items():
        fields[name][rows, columns] = value
    return replace(surface, **fields)


def test_looking_square_at_the_surface_is_no_angle():
    assert incidence_deg(np.array([0.0]), RADIUS_M, STANDOFF_M)[0] == 0


def test_the_ray_that_touches_the_cable_stands_at_ninety_degrees():
    """Tangent: cos(azimuth) = radius / standoff."""
    limb = np.arccos(RADIUS_M / STANDOFF_M)
    np.testing.assert_allclose(incidence_deg(np.array([-limb, limb]), RADIUS_M, STANDOFF_M), 90)


def test_a_quarter_turn_away_by_hand():
    """At 90 degrees the point is (0, r): the line to (d, 0) leaves the normal by 90 + atan(r / d) degrees."""
    found = incidence_deg(np.array([np.pi / 2]), RADIUS_M, STANDOFF_M)[0]
    assert found == pytest.approx(90 + np.degrees(np.arctan(RADIUS_M / STANDOFF_M)))


def test_incidence_is_the_angle_between_normal_and_line_of_sight():
    azimuth = np.deg2rad(np.arange(-70, 71, 7))
    normal = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    sight = np.array([STANDOFF_M, 0]) - RADIUS_M * normal
    cosine = np.sum(normal * sight, axis=1) / np.linalg.norm(sight, axis=1)
    found = incidence_deg(azimuth, RADIUS_M, STANDOFF_M)
    np.testing.assert_allclose(found, np.degrees(np.arccos(cosine)), atol=1e-6)


@pytest.mark.parametrize("azimuth_deg", [0.0, 90.0, 215.0])
@pytest.mark.parametrize("limit_deg", [50.0, 62.0])
def test_the_limb_is_cut_where_the_incidence_passes_the_limit(azimuth_deg, limit_deg):
    found = crop(block_surface(azimuth_deg), azimuth_deg, incidence_deg=limit_deg)
    # by the law of sines: the azimuth of incidence i is i - asin(r sin i / d)
    i = np.deg2rad(limit_deg)
    cut = limit_deg - np.degrees(np.arcsin(RADIUS_M * np.sin(i) / STANDOFF_M))
    turned = np.linspace(-75, 75, 301)
    np.testing.assert_array_equal(found.keep[60], np.abs(turned) <= cut)
    assert found.incidence_deg[np.abs(turned) <= cut].max() <= limit_deg


def test_doubtful_cells_go_and_good_ones_around_them_stay():
    surface = spoiled(block_surface(), slice(40, 60), slice(140, 160), score=0.1)
    found = crop(surface)
    assert not found.keep[40:60, 140:160].any()
    assert found.keep[20:36, 100:200].all()
    assert crop(surface, least_score=0.05).keep[40:60, 140:160].all()


def test_a_closed_hole_stays_though_it_has_no_score():
    hole = (slice(50, 56), slice(150, 156))
    surface = spoiled(block_surface(), *hole, score=np.nan, measured=False)
    assert crop(surface).keep[hole].all()


def test_an_open_hole_goes():
    hole = (slice(50, 56), slice(150, 156))
    assert not crop(spoiled(block_surface(), *hole, radius_m=np.nan)).keep[hole].any()


def test_a_protrusion_narrower_than_the_fringe_is_cut_and_a_broad_one_stays():
    surface = block_surface()
    radius = surface.radius_m.copy()
    radius[:60] = np.nan
    radius[20:60, 100:104] = RADIUS_M  # 2 mm wide
    radius[20:60, 200:230] = RADIUS_M  # 15 mm wide
    found = crop(replace(surface, radius_m=radius))
    assert not found.keep[20:56, 100:104].any()
    assert found.keep[24:60, 205:225].all()


def test_an_island_is_cut():
    surface = block_surface()
    radius = surface.radius_m.copy()
    radius[:60] = np.nan
    radius[30:33, 150:153] = RADIUS_M
    assert not crop(replace(surface, radius_m=radius)).keep[:55].any()


def test_a_block_of_which_nothing_is_left_is_refused():
    with pytest.raises(StageError) as told:
        crop(block_surface(), least_score=0.99)
    assert str(told.value) == (
        "crop: nothing of Block1 is left; raise crop.incidence_deg or lower crop.least_score."
    )


def test_only_the_stretch_between_two_stations_stays():
    whole = crop(block_surface()).keep
    found = crop(block_surface(), from_m=0.01, to_m=0.04).keep
    y_m = CELL_M * np.arange(120)
    inside = (y_m >= 0.01) & (y_m <= 0.04)
    assert not found[~inside].any()
    # the opening rounds the two new corners on each side, no more
    assert whole[inside].sum() - found[inside].sum() < 4 * 6 * 6
    np.testing.assert_array_equal(found[40:60], whole[40:60])


@pytest.mark.parametrize(
    ("limits", "kept"), [({"from_m": 0.03}, slice(60, None)), ({"to_m": 0.03}, slice(0, 60))]
)
def test_one_station_alone_cuts_one_end(limits, kept):
    found = crop(block_surface(), **limits).keep.any(axis=1)
    assert found[kept].all()
    assert 58 < found.sum() < 62


def test_a_stretch_that_ends_before_it_begins_is_refused():
    with pytest.raises(StageError) as told:
        crop(block_surface(), from_m=0.04, to_m=0.01)
    assert str(told.value) == (
        "crop: crop.from_m is 0.04 and crop.to_m is 0.01; "
        "let the stretch that stays end behind its beginning."
    )


def test_a_stretch_beyond_the_block_is_refused():
    with pytest.raises(StageError) as told:
        crop(block_surface(), from_m=1.0)
    assert str(told.value) == (
        "crop: nothing of Block1 is left; raise crop.incidence_deg or lower crop.least_score, "
        "or move crop.from_m and crop.to_m apart."
    )
