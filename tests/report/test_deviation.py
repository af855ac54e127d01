"""Distances from the ideal surface are those that were put in, and their colours say so."""

import matplotlib as mpl
import numpy as np
import pytest

from pipeline.cable.measure import Measurement, Section
from pipeline.cable.relief import Relief
from pipeline.cable.ring import Alignment, Ring
from pipeline.report.deviation import (
    NOT_MEASURED,
    base_deviation_mm,
    circle_deviation_mm,
    diverging_colours,
    is_measured,
    mean_diameter_mm,
    profile_at,
    section_deviation_mm,
)

Y_M = np.linspace(0, 0.1, 21)
AZIMUTH = -np.pi + (np.arange(360) + 0.5) * np.pi / 180


def section(diameter_mm):
    unknown = dict.fromkeys(
        (
            *("sigma_mm", "sigma_image_mm", "sigma_scale_mm", "sigma_lens_mm", "base_diameter_mm"),
            *("base_sigma_mm", "min_mm", "max_mm", "coverage_deg"),
        ),
        0.0,
    )
    empty = {"centre_mm": np.zeros(2), "points_mm": np.zeros((0, 2))}
    return Section(name="A", position_m=0.0, diameter_mm=diameter_mm, **unknown, **empty)


def measurement(heights_mm=None, centre_mm=(0.0, 0.0), diameters=(110.0,)):
    """A straight cable whose centre lies off the axis, with its profile 0.1 mm thicker each 10 mm."""
    relief = Relief(
        y_m=Y_M,
        azimuth=AZIMUTH,
        base_diameter_mm=np.full(21, 110.0),
        base_noise_mm=np.zeros(21),
        height_mm=np.zeros((21, 360), np.float32) if heights_mm is None else heights_mm,
        level_mm=0.2,
        features=(),
    )
    return Measurement(
        sections=tuple(section(d) for d in diameters),
        profile_y_m=Y_M,
        profile_diameter_mm=110 + 10 * Y_M,
        profile_sigma_mm=np.full(21, 0.02),
        profile_centre_mm=np.tile(centre_mm, (21, 1)),
        straightness_mm_per_m=0.0,
        unmeasured=(),
        relief=relief,
    )


def tube(radius_mm, azimuth, y_m, centre_mm=(0.0, 0.0)):
    x, z = radius_mm * np.cos(azimuth) + centre_mm[0], -radius_mm * np.sin(azimuth) + centre_mm[1]
    return np.column_stack([x / 1000, np.broadcast_to(y_m, x.shape), z / 1000])


def test_the_mean_is_over_the_stations():
    assert mean_diameter_mm(measurement(diameters=(110.0, 111.0, 113.0))) == pytest.approx(111 + 1 / 3)


def test_a_tube_about_its_own_axis_deviates_by_its_excess_everywhere():
    points = tube(55.3, AZIMUTH, 0.043, centre_mm=(2.0, -1.0))
    found = circle_deviation_mm(points, measurement(centre_mm=(2.0, -1.0)), 110.0)
    np.testing.assert_allclose(found, 0.3, atol=1e-9)


def test_the_axis_is_held_beyond_the_profile_and_bridged_where_nothing_was_seen():
    run = measurement(centre_mm=(2.0, -1.0))
    run.profile_centre_mm[5:8] = np.nan
    for y_m in (-0.01, 0.03, 0.11):
        points = tube(55.0, AZIMUTH, y_m, centre_mm=(2.0, -1.0))
        np.testing.assert_allclose(circle_deviation_mm(points, run, 110.0), 0, atol=1e-9)


def test_heights_over_the_base_are_found_at_their_azimuth_and_position():
    heights = np.zeros((21, 360), np.float32)
    heights[:, 200:240] = 0.8  # azimuths 20 to 60 degrees
    heights[:, :40] = np.nan
    at_deg = np.array([40.0, 0.0, -160.0, 179.9])
    found = base_deviation_mm(tube(55.0, np.radians(at_deg), 0.05), measurement(heights))
    np.testing.assert_allclose(found[[0, 1, 3]], [0.8, 0, 0], atol=1e-6)
    assert np.isnan(found[2])


def test_a_section_is_told_direction_by_direction_about_its_centre():
    angle = np.radians(np.arange(0, 180, 0.25) + 0.1)
    points = np.column_stack([3 + 55.2 * np.cos(angle), 1 + 55.2 * np.sin(angle)])
    angles_deg, away = section_deviation_mm(points, np.array([3.0, 1.0]), 55.0)
    np.testing.assert_allclose(angles_deg, np.arange(360) + 0.5)
    np.testing.assert_allclose(away[:180], 0.2, atol=1e-9)
    assert np.isnan(away[180:]).all()


def test_the_profile_answers_between_its_places_and_nowhere_else():
    assert profile_at(measurement(), 0.0425) == (pytest.approx(110.425), pytest.approx(0.02))
    for outside in (-0.001, 0.1001):
        assert np.isnan(profile_at(measurement(), outside)).all()
    holed = measurement()
    holed.profile_diameter_mm[8] = np.nan
    assert np.isnan(profile_at(holed, 0.0425)[0])


def test_colours_are_those_of_the_reports_maps():
    values = np.linspace(-0.6, 0.6, 101)
    wanted = mpl.colormaps["RdBu_r"]((np.clip(values / 0.5, -1, 1) + 1) / 2)[:, :3] * 255
    np.testing.assert_allclose(diverging_colours(values, 0.5), wanted, atol=3)
    np.testing.assert_array_equal(diverging_colours(np.array([np.nan]), 0.5), [NOT_MEASURED])


def test_what_was_only_closed_is_told_from_what_was_measured():
    measured = np.ones((21, 360), bool)
    measured[8:12, 200:240] = False  # 40 to 55 mm along, azimuths 20 to 60 degrees
    ring = Ring(
        alignment=Alignment(rotation=np.eye(3), translation=np.zeros(3)),
        azimuth=AZIMUTH,
        y_m=Y_M,
        radius_m=np.full((21, 360), 0.055),
        measured=measured,
        picture=np.zeros((1, 1, 3), np.uint8),
        picture_known=np.ones((1, 1), bool),
        picture_y_m=np.zeros(1),
        picture_azimuth=np.zeros(1),
        texel_mm=1.0,
    )
    around = np.radians([40.0, 19.0, -40.0])
    np.testing.assert_array_equal(is_measured(tube(55.0, around, 0.05), ring), [False, True, True])
    assert is_measured(tube(55.0, around, 0.06), ring).all()
