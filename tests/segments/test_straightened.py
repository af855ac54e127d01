"""The surface of a bowed segment about its axis: as round as the cable is."""

from dataclasses import replace

import numpy as np
import pytest

from pipeline.segments.straightened import straightened
from tests.segments.test_whole_ring import ring

LENGTH_M, RADIUS_M = 0.8, 0.055


def axis_mm(y_m):
    """(n, 2) an arc towards x with a wave along z, about the line that fits best."""
    part = y_m / LENGTH_M - 0.5
    return np.stack([0.4 * (4 * part**2 - 1 / 3), 0.1 * np.sin(2 * np.pi * part)], axis=-1)


def bowed(height_m):
    """The segment's surface about the straight line: at every azimuth, as far as the shifted circle is."""
    straight = ring(0.0, LENGTH_M, 0.0)
    x, z = axis_mm(straight.y_m)[:, :, None].swapaxes(0, 1) / 1000
    azimuth = straight.azimuth
    along = x * np.cos(azimuth) - z * np.sin(azimuth)
    across = x * np.sin(azimuth) + z * np.cos(azimuth)
    radius = along + np.sqrt((RADIUS_M + height_m(azimuth)) ** 2 - across**2)
    return replace(straight, radius_m=radius.astype(np.float32))


def test_radii_are_about_the_axis():
    before = bowed(lambda azimuth: 0 * azimuth)
    places = np.arange(0, LENGTH_M, 0.01)
    noise = np.random.default_rng(1).normal(0, 0.01, (len(places), 2))
    after = straightened(before, places, axis_mm(places) + noise)
    told = (before.y_m > 0) & (before.y_m < LENGTH_M - 0.01)
    assert 1000 * np.abs(before.radius_m - RADIUS_M)[told].max() > 0.2, "it must be bowed to be a test"
    assert 1000 * np.abs(after.radius_m - RADIUS_M)[told].max() < 0.03
    assert 1000 * np.abs(after.radius_m - RADIUS_M).max() < 0.06, "beyond the axis it goes on as at its end"


def test_what_stands_out_stays():
    def bump(azimuth):
        return 0.0005 * np.exp(-((azimuth - 1.0) ** 2) / 0.02)

    places = np.arange(0, LENGTH_M, 0.01)
    after = straightened(bowed(bump), places, axis_mm(places))
    middle = np.argmin(np.abs(after.y_m - LENGTH_M / 2))
    assert after.radius_m[middle] == pytest.approx(RADIUS_M + bump(after.azimuth), abs=1.5e-5)


def test_holes_stay_and_an_axis_of_few_places_changes_nothing():
    one = bowed(lambda azimuth: 0 * azimuth)
    holed = replace(one, radius_m=np.where(np.arange(len(one.azimuth)) < 5, np.nan, one.radius_m))
    places = np.arange(0, LENGTH_M, 0.01)
    assert np.isnan(straightened(holed, places, axis_mm(places)).radius_m[:, :5]).all()
    assert straightened(one, places[:8], axis_mm(places[:8])) is one
