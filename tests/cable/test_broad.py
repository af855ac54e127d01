"""Broad windows fill what narrow ones leave open, and only what two halves vouch for."""

import numpy as np

from pipeline.cable import broad
from pipeline.cable.surface_view import SweepGrid
from pipeline.cable.sweep import SweepResult
from pipeline.core.axis import AxisCurve

AXIS = AxisCurve(origin_y_m=0.0, coefficients=np.zeros((2, 1)))


def grid(rows, columns):
    return SweepGrid(axis=AXIS, azimuth=np.linspace(-1, 1, columns), y_m=np.linspace(0, 0.1, rows))


def surface(shape, radius_mm=55.0, score=0.9, apart_mm=0.0):
    radius = np.full(shape, radius_mm / 1000, dtype=np.float32)
    half = np.float32(apart_mm / 2000)
    return SweepResult(
        radius_m=radius,
        score=np.full(shape, score, dtype=np.float32),
        radius_ahead_m=radius + half,
        radius_behind_m=radius - half,
    )


def test_halves_that_differ_and_pictures_that_disagree_are_not_trusted():
    assert broad.trusted(surface((3, 3), apart_mm=0.3), 0.5, 0.35).all()
    assert not broad.trusted(surface((3, 3), apart_mm=0.4), 0.5, 0.35).any()
    assert not broad.trusted(surface((3, 3), score=0.45), 0.5, 0.35).any()


def test_what_only_one_side_saw_must_agree_twice_as_well():
    for score, stands in ((0.7, False), (0.8, True)):
        found = surface((2, 2), score=score)
        found.radius_behind_m[:] = np.nan
        assert broad.trusted(found, 0.5, 0.35).all() == stands


def test_a_cell_that_agrees_among_many_that_do_not_agrees_by_chance():
    rng = np.random.default_rng(4)
    stands = np.ones((200, 200), dtype=bool)
    stands[:, :100] = rng.random((200, 100)) < 0.5
    kept = broad.vouched(stands)
    assert not kept[:, :80].any()
    assert kept[:, 120:].all()


def test_standing_cells_stay_and_open_ones_take_the_nearest_broad_cell():
    fine, wide = grid(21, 41), grid(11, 21)
    stands = np.zeros((21, 41), dtype=bool)
    stands[:, :20] = True
    coarse = surface((11, 21), radius_mm=56.0)
    coarse.radius_m[3, 15] = 0.057
    found = broad.filled(surface((21, 41)), fine, stands, coarse, wide)
    assert np.all(found.radius_m[stands] == np.float32(0.055))
    assert found.radius_m[6, 30] == np.float32(0.057)
    assert np.sum(found.radius_m[~stands] != np.float32(0.056)) <= 9
