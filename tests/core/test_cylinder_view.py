"""Rays meet the cable where an independently written ray tracer says, and go there and back."""

import numpy as np
import pytest

from pipeline.core.cylinder_view import azimuths, image_points, meet_cylinder, surface_points
from tests.cable import scene


@pytest.fixture(scope="module")
def view():
    return scene.Scene(
        poses=scene.poses(azimuth_deg=130.0, sway_deg=2.0, sway_mm=5.0), lens=scene.lens(scene.BARREL)
    )


def grid_px():
    column, row = np.meshgrid(np.linspace(1, 319, 30), np.linspace(1, 199, 40))
    return np.stack([column.ravel(), row.ravel()], axis=1)


@pytest.mark.parametrize("frame", [0, 4, 9])
def test_rays_meet_the_surface_where_the_ray_tracer_says(view, frame):
    pose = view.poses.rotations[frame], view.poses.translations[frame]
    found = meet_cylinder(view.lens, *pose, grid_px(), view.radius_m)
    truth = view.meet(frame, grid_px())
    assert 0.5 < np.isfinite(truth[:, 0]).mean() < 0.9  # the picture holds cable and background
    np.testing.assert_array_equal(np.isfinite(found), np.isfinite(truth))
    np.testing.assert_allclose(found, truth, atol=1e-12)


def test_the_surface_facing_the_camera_is_met_and_not_the_back(view):
    points = view.meet(0, grid_px())
    turned = np.angle(np.exp(1j * (azimuths(points) - np.deg2rad(130))))
    limb = np.arccos(view.radius_m / scene.STANDOFF_M)
    assert np.nanmax(np.abs(turned)) < limb + 0.05


def test_a_surface_point_is_seen_at_the_pixel_whose_ray_meets_it(view):
    pose = view.poses.rotations[3], view.poses.translations[3]
    points = meet_cylinder(view.lens, *pose, grid_px(), view.radius_m)
    seen = np.isfinite(points[:, 0])
    back = image_points(view.lens, *pose, points[seen])
    np.testing.assert_allclose(back, grid_px()[seen], atol=1e-9)


def test_points_of_the_surface_have_the_azimuth_they_were_made_for():
    azimuth = np.linspace(-3.1, 3.1, 25)
    points = surface_points(azimuth, np.array(0.2), 0.055)
    np.testing.assert_allclose(points[:, 1], 0.2)
    np.testing.assert_allclose(azimuths(points), azimuth)
    np.testing.assert_allclose(points[:, [0, 2]], 0.055 * np.stack([np.cos(azimuth), -np.sin(azimuth)], 1))
