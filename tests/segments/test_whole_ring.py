"""Segments of a made-up surface laid end to end: every place has its radius and its colour."""

import numpy as np
import pytest

from pipeline.cable.ring import Alignment, Ring
from pipeline.segments import whole_ring
from pipeline.segments.whole_ring import Place, join_rings

LENGTH_M, ENDS_M, TURN = 2.0, 0.015, 0.3


def true_radius(azimuth, y_m):
    return 0.055 + 0.001 * np.sin(2 * azimuth + 9 * y_m)


def true_grey(azimuth, y_m):
    return 120 + 60 * np.cos(azimuth) * np.cos(5 * y_m)


def ring(first_m, last_m, roll, cell_m=0.002, brighter=0.0, hole=False):
    """A segment's own surface: its y counts from ``first_m``, its azimuths are ``roll`` less than true."""
    columns = round(2 * np.pi * 0.055 / cell_m)
    azimuth = -np.pi + (np.arange(columns) + 0.5) * 2 * np.pi / columns
    y_m = np.arange(-ENDS_M, last_m - first_m + ENDS_M, cell_m)
    turned, along = np.meshgrid(azimuth + roll, y_m + first_m)
    grey = true_grey(turned, along) + brighter
    radius = true_radius(turned, along)
    if hole:
        radius = np.where((np.abs(turned - 1.0) < 0.3) & (np.abs(along - 0.4) < 0.05), np.nan, radius)
    return Ring(
        alignment=Alignment(rotation=np.eye(3), translation=np.zeros(3)),
        azimuth=azimuth,
        y_m=y_m,
        radius_m=radius.astype(np.float32),
        measured=np.isfinite(radius),
        picture=np.repeat(np.rint(grey)[..., None], 3, axis=2).astype(np.uint8),
        picture_known=np.ones(grey.shape, bool),
        picture_y_m=y_m,
        picture_azimuth=azimuth,
        texel_mm=1000 * cell_m,
    )


PLACES = (
    Place(start_m=0.0, roll=0.0, fade_in_m=None, fade_out_m=(0.9, 1.0)),
    Place(start_m=0.8, roll=TURN, fade_in_m=(0.9, 1.0), fade_out_m=None),
)


def joined(**second):
    rings = (ring(0.0, 1.1, 0.0, hole=True), ring(0.8, LENGTH_M, TURN, **second))
    return join_rings(iter(rings), PLACES, LENGTH_M)


def test_radius_and_colour_are_those_of_the_place():
    whole = joined()
    turned, along = np.meshgrid(whole.azimuth, whole.y_m)
    hole = (np.abs(turned - 1.0) < 0.36) & (np.abs(along - 0.4) < 0.055)
    assert np.abs(whole.radius_m - true_radius(turned, along))[~hole].max() < 2e-5
    turned, along = np.meshgrid(whole.picture_azimuth, whole.picture_y_m)
    assert np.abs(whole.picture[..., 0] - true_grey(turned, along)).max() < 3
    assert whole.picture_known.all()


def test_the_whole_length_and_girth_are_covered_by_cells_of_the_segments_size():
    whole = joined()
    assert whole.y_m[0] == pytest.approx(-ENDS_M, abs=0.002)
    assert whole.y_m[-1] == pytest.approx(LENGTH_M + ENDS_M, abs=0.002)
    assert whole.y_m[1] - whole.y_m[0] == pytest.approx(0.002, rel=0.02)
    assert np.ptp(whole.azimuth) * len(whole.azimuth) / (len(whole.azimuth) - 1) == pytest.approx(2 * np.pi)


def test_a_hole_stays_a_hole():
    whole = joined()
    row, column = np.argmin(np.abs(whole.y_m - 0.4)), np.argmin(np.abs(whole.azimuth - 1.0))
    assert np.isnan(whole.radius_m[row, column])
    assert not whole.measured[row, column]


def test_neighbours_fade_into_each_other():
    whole = joined(brighter=20.0)
    row = [np.argmin(np.abs(whole.picture_y_m - y)) for y in (0.85, 0.95, 1.05)]
    turned, along = np.meshgrid(whole.picture_azimuth, whole.picture_y_m[row])
    brighter = (whole.picture[row, :, 0] - true_grey(turned, along)).mean(axis=1)
    assert brighter == pytest.approx([0, 10, 20], abs=1)


def test_a_long_cable_gets_coarser_cells_and_no_more_of_them(monkeypatch):
    monkeypatch.setattr(whole_ring, "MOST_CELLS", 20_000)
    monkeypatch.setattr(whole_ring, "MOST_TEXELS", 50_000)
    whole = joined()
    assert whole.radius_m.size == pytest.approx(20_000, rel=0.02)
    assert whole.picture[..., 0].size == pytest.approx(50_000, rel=0.02)
    turned, along = np.meshgrid(whole.azimuth, whole.y_m)
    away = ~((np.abs(turned - 1.0) < 0.5) & (np.abs(along - 0.4) < 0.08))
    assert np.abs(whole.radius_m - true_radius(turned, along))[away].max() < 1e-4


def test_a_missing_segment_leaves_a_gap_and_its_neighbour_whole():
    whole = join_rings(
        iter([ring(0.0, 0.6, 0.0), ring(1.2, LENGTH_M, 0.0)]),
        [Place(start_m=y, roll=0.0, fade_in_m=None, fade_out_m=None) for y in (0.0, 1.2)],
        LENGTH_M,
    )
    known = np.isfinite(whole.radius_m).all(axis=1)
    gap = (whole.y_m > 0.62) & (whole.y_m < 1.18)
    assert not known[gap].any()
    assert known[(whole.y_m < 0.61) | (whole.y_m > 1.19)].all()
